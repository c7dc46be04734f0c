"""Time from each fault to the safe state of each actuator, as the fault matrix measured it, beside the limits."""

import json
from pathlib import Path
from typing import Any

from robustness.fault_judge import HOLD_S
from robustness.fault_table import Actuator

DEFAULT_FAULTS = Path(__file__).parents[2] / "docs" / "faults.json"
"""File of the fault matrix's findings that is kept with the source."""


def safe_state_times(path: Path) -> dict[str, Any]:
    """Times to the safe state from a file of the fault matrix.

    Returns:
        `limits_s`: hold time of each actuator, s. `faults`: name, required and measured outcome, and `safe_s` of the
            faults that made an actuator safe. `note`: empty, or that the file is missing.
    """
    limits_s = {actuator.value: HOLD_S[actuator] for actuator in Actuator}
    if not path.is_file():
        return {"limits_s": limits_s, "faults": [], "note": f"no {path.name}: the fault matrix has not been run"}
    faults = [
        {name: entry[name] for name in ("fault", "expected", "outcome", "safe_s")}
        for entry in json.loads(path.read_text("utf-8"))
        if entry["safe_s"]
    ]
    return {"limits_s": limits_s, "faults": faults, "note": ""}
