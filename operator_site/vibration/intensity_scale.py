"""Which motor speed shows what Eq. 1 and 2 ask for: the paper's way, or matched in what is felt.

The motor couples amplitude and frequency: what is felt is its acceleration, which grows with the square of the speed.
A law that is linear in speed is therefore a square law to the finger. Matched, the same law is linear to the finger.
"""

import math

from common.config import VibrationScale
from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM

SHOWN: dict[VibrationScale, tuple[float, float]] = {"speed": (0.35, 0.25), "intensity": (1.0, 0.8)}
"""A speed below the perception floor is shown as the floor from the first share of it, until the second.

As the paper has it, plain plastic stroked at 50 mm/s asks for half the floor and is felt; foam asks for a sixth of it
and is not. Where the intensity is matched, what lies below the floor is what a finger would not feel.
"""


class IntensityScale:
    """Speed of one motor, with the memory that its hysteresis needs."""

    def __init__(self, scale: VibrationScale = "speed") -> None:
        self._scale: VibrationScale = scale
        self._from, self._until = SHOWN[scale]
        self._shown = False

    def still(self) -> None:
        """Nothing is to be felt."""
        self._shown = False

    def rpm(self, wanted_rpm: float) -> float:
        """Speed to show, rpm: 0, or between the perception floor and the motor's largest."""
        if self._scale == "intensity":
            wanted_rpm = MOTOR_MAX_RPM * math.sqrt(max(0.0, wanted_rpm) / MOTOR_MAX_RPM)
        self._shown = wanted_rpm >= MOTOR_FLOOR_RPM * (self._until if self._shown else self._from)
        return min(MOTOR_MAX_RPM, max(MOTOR_FLOOR_RPM, wanted_rpm)) if self._shown else 0.0
