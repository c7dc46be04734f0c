"""The operator gate's output: what may reach the devices of the operator site."""

from dataclasses import dataclass

from common.faults.fault import Fault
from common.fingers import FINGERS
from operator_site.safety.limit_flags import Limit

SKIN_NEUTRAL_C = 33.0
"""Set-point shown while a plate has no reading, C; its drive is off then."""


@dataclass(slots=True)
class GatedOutput:
    """What may reach the devices, five fingers each, and what the gate did."""

    force_n: list[float]
    motor_rpm: list[float]
    plate_set_c: list[float]
    peltier_drive: list[float]
    limited: list[int]
    """`Limit` bits of each finger."""
    fault: Fault | None

    @classmethod
    def neutral(cls, fault: Fault | None) -> "GatedOutput":
        """Outputs of a tick without a gate: no force, no vibration, no drive; `fault` is the latched one, if any."""
        n = len(FINGERS)
        released = [Limit.RELEASED.value] * n
        return cls([0.0] * n, [0.0] * n, [SKIN_NEUTRAL_C] * n, [0.0] * n, released, fault)
