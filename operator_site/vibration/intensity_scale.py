"""Scales the speed of Eq. 1 and 2 to a motor speed, as in the paper or linear in perceived intensity.

The motor couples amplitude and frequency. A finger feels its acceleration, which grows with the square of the speed.
A law that is linear in speed is therefore quadratic in intensity. The scale `intensity` makes the law linear in
intensity.
"""

import math

from common.config import VibrationScale
from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM

SHOWN: dict[VibrationScale, tuple[float, float]] = {"speed": (0.35, 0.25), "intensity": (1.0, 0.8)}
"""Hysteresis of raising a lower speed to the perception floor: it begins at the first share of it, ends at the second.

On the paper's scale, plain plastic stroked at 50 mm/s needs half the floor and is displayed. Foam needs a sixth of it
and is not displayed. On the intensity scale, speeds below the floor are imperceptible.
"""


class IntensityScale:
    """Scales the speed of one motor, with hysteresis at the perception floor."""

    def __init__(self, scale: VibrationScale = "speed") -> None:
        self._scale: VibrationScale = scale
        self._from, self._until = SHOWN[scale]
        self._shown = False

    def still(self) -> None:
        """Reset the hysteresis, because nothing is displayed."""
        self._shown = False

    def rpm(self, wanted_rpm: float) -> float:
        """Return the motor speed, rpm: 0, or between the perception floor and the motor's largest speed."""
        if self._scale == "intensity":
            wanted_rpm = MOTOR_MAX_RPM * math.sqrt(max(0.0, wanted_rpm) / MOTOR_MAX_RPM)
        self._shown = wanted_rpm >= MOTOR_FLOOR_RPM * (self._until if self._shown else self._from)
        return min(MOTOR_MAX_RPM, max(MOTOR_FLOOR_RPM, wanted_rpm)) if self._shown else 0.0
