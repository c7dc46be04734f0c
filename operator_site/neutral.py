"""Neutral outputs of the operator's site: what is requested and written where a renderer or a gate has failed."""

from common.fingers import FINGERS
from operator_site.fingertips import Requested
from operator_site.gate import SKIN_NEUTRAL_C, GatedOutput, Limit


def neutral_request() -> Requested:
    """No force, no vibration and no drive of any finger, as a gate's input."""
    return Requested(_zeros(), _zeros(), [SKIN_NEUTRAL_C] * len(FINGERS), _zeros(), [0] * len(FINGERS))


def neutral_output(fault: str | None) -> GatedOutput:
    """The same for the devices, without a gate, and the fault that is latched, if any."""
    limited = [Limit.RELEASED.value] * len(FINGERS)
    return GatedOutput(_zeros(), _zeros(), [SKIN_NEUTRAL_C] * len(FINGERS), _zeros(), limited, fault)


def _zeros() -> list[float]:
    return [0.0] * len(FINGERS)
