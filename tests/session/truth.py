"""What really happened at the simulated devices of a session, for tests to judge."""

from common.fingers import FINGERS
from studies.fault_judge import Floats, Truth
from studies.fault_table import FREE, STROKING
from studies.faults import read_truth

__all__ = ["FELT_N", "HEATS", "LATE_S", "STROKES", "Floats", "Truth", "between", "read_truth"]

STROKES, HEATS = FINGERS.index(STROKING), FINGERS.index(FREE)
"""The finger that strokes an object, and the one in the air whose sensor is heated."""
LATE_S = 0.030
"""What the machine may add to a hold time: a log entry every 10 ms, and a scheduler that others use too."""
FELT_N = 0.15
"""Least force that counts as being felt."""


def between(time_s: Floats, values: Floats, from_s: float, to_s: float) -> Floats:
    """The values written down in from_s..to_s, of which there must be some."""
    found = values[(time_s > from_s) & (time_s < to_s)]
    assert len(found), f"nothing was written down from {from_s} s to {to_s} s"
    return found
