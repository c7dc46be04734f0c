"""Capabilities that the sites exchange at hello, and their comparison."""

import hashlib
from typing import Any

from common.limits import AGE_DEFAULT_S, GAP_S
from common.timing.timeouts import InconsistentTimeouts, check_ladder
from common.wire.messages import TOUCH_RANGES
from common.wire.packets import SCHEMA_VERSION

LAYOUT = hashlib.sha256(
    ",".join(f"{name}:{low:g}:{high:g}" for name, (low, high) in TOUCH_RANGES.items()).encode()
).hexdigest()[:16]
"""Hash of the touch block's columns and ranges; sites with different hashes would misread each other."""

MOTION_NUMBERS = "from the answer to hello"
"""Where the sequence numbers of motion begin: only the operator of the session knows its first one."""

OPERATOR = "operator"
OBSERVER = "observer"


def capabilities(fingers: tuple[str, ...], rate_hz: float, **more: Any) -> dict[str, Any]:
    """Return a site's own capabilities, as sent in a hello and its answer; `rate_hz` is that of its loop and packets.

    `more` are fields of one kind of site, such as its calibration's hash or its output ranges.
    """
    same = {"schema": SCHEMA_VERSION, "layout": LAYOUT, "motion_numbers": MOTION_NUMBERS}
    return {**same, "fingers": list(fingers), "rate_hz": rate_hz, **more}


def misreading(theirs: dict[str, Any]) -> str:
    """Return why this site would misread packets of the far side; empty when it would not."""
    if theirs.get("layout") != LAYOUT:
        return "touch is laid out differently on the two sites: install the same version on both"
    return ""


def disagreement(ours: dict[str, Any], theirs: dict[str, Any], gap_s: float = GAP_S) -> str:
    """Return why two sites cannot work together; empty when they can. `theirs` may be malformed.

    Args:
        ours: this site's capabilities.
        theirs: capabilities of the far side.
        gap_s: maximum gap between packets, s; a longer gap causes this site's safe state.
    """
    if problem := misreading(theirs):
        return problem
    if theirs.get("motion_numbers") != MOTION_NUMBERS:
        return "motion is numbered differently on the two sites: install the same version on both"
    if theirs.get("fingers") != ours["fingers"]:
        return f"the far side has fingers {theirs.get('fingers')}, this site has {ours['fingers']}: configure the same"
    try:
        check_ladder(ours["rate_hz"], gap_s, ours.get("max_age_s", AGE_DEFAULT_S), theirs.get("rate_hz"))
    except InconsistentTimeouts as broken:
        return str(broken)
    return ""
