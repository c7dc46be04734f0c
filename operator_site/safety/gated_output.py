"""Outputs to the devices of the operator site, before and after the gate."""

from dataclasses import dataclass
from typing import NewType

from common.faults.fault import Fault
from common.fingers import FINGERS
from operator_site.safety.limit_flags import Limit

SKIN_NEUTRAL_C = 33.0
"""Set-point of a plate without a reading, C; its drive is off then."""


@dataclass(slots=True)
class Outputs:
    """Outputs for five fingers: requests of the renderer, or what the gate passes."""

    force_n: list[float]
    motor_rpm: list[float]
    plate_set_c: list[float]
    peltier_drive: list[float]
    limited: list[int]
    """`Limit` bits of each finger, of the renderer's limits and of the gate's."""
    fault: Fault | None = None
    """The fault that the gate has latched; None without one."""


GatedOutput = NewType("GatedOutput", Outputs)
"""Outputs that the gate has passed; only these may reach a device."""


def neutral(limited: int = 0) -> Outputs:
    """Return outputs of no force, no vibration and no drive for all fingers, with these `Limit` bits."""
    n = len(FINGERS)
    return Outputs([0.0] * n, [0.0] * n, [SKIN_NEUTRAL_C] * n, [0.0] * n, [limited] * n)


def released(fault: Fault | None) -> GatedOutput:
    """Return the neutral outputs of a tick without a gate; `fault` is the latched one, if any."""
    outputs = neutral(Limit.RELEASED.value)
    outputs.fault = fault
    return GatedOutput(outputs)
