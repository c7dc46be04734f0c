"""Time from each fault to the safe state of each actuator, as the fault matrix measured it, beside the limits."""

import json
from pathlib import Path
from typing import Any

from robustness.fault_judge import HOLD_S
from robustness.fault_table import Actuator

DEFAULT_FAULTS = Path(__file__).parents[2] / "docs" / "faults.json"
"""File of the fault matrix's findings that is kept with the source."""


class FaultsProblem(ValueError):
    """A file without the format of the fault matrix."""


def safe_state_times(path: Path) -> dict[str, Any]:
    """Times to the safe state from a file of the fault matrix.

    Returns:
        `limits_s`: hold time of each actuator, s. `faults`: name, required and measured outcome, and `safe_s` of the
            faults that made an actuator safe. `note`: empty, or that the file is missing.

    Raises:
        FaultsProblem: the file is something else.
    """
    limits_s = {actuator.value: HOLD_S[actuator] for actuator in Actuator}
    if not path.is_file():
        return {"limits_s": limits_s, "faults": [], "note": f"no {path.name}: the fault matrix has not been run"}
    try:
        entries = json.loads(path.read_text("utf-8"))
    except ValueError as error:
        raise FaultsProblem(f"{path}: not JSON: {error}") from None
    if not isinstance(entries, list):
        raise FaultsProblem(f"{path}: expected a list of faults as the fault matrix writes it")
    faults = [_fault(path, number, entry) for number, entry in enumerate(entries, start=1)]
    return {"limits_s": limits_s, "faults": [fault for fault in faults if fault["safe_s"]], "note": ""}


def _fault(path: Path, number: int, entry: Any) -> dict[str, Any]:
    known = {actuator.value for actuator in Actuator}
    try:
        safe_s = {str(actuator): float(s) for actuator, s in entry["safe_s"].items()}
        fault = {name: entry[name] for name in ("fault", "expected", "outcome")}
    except (KeyError, TypeError, ValueError, AttributeError):
        raise FaultsProblem(f"{path}: entry {number}: expected fault, expected, outcome and safe_s") from None
    if strange := set(safe_s) - known:
        raise FaultsProblem(
            f"{path}: entry {number}: no actuator {min(strange)!r}; there are {', '.join(sorted(known))}"
        )
    return {**fault, "safe_s": safe_s}
