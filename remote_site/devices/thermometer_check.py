"""Whether a reading of the spreading-resistance sensor can be true."""

from common.buses.thermometry import COUNT_MAX, ssr_c
from common.wire.messages import ThermalReason

FROZEN_S = 1.0
"""A plate being heated that repeats one count for this long is not being measured, s."""


class ThermometerCheck:
    """Tells a broken sensor from a reading: open, short, jumping or frozen while driven."""

    __slots__ = ("_counts", "_since_s", "_t_s")

    MAX_RATE_K_S = 40.0
    """Faster than any contact can change the plate, K/s."""

    def __init__(self) -> None:
        self._counts: int | None = None
        self._t_s = 0.0
        self._since_s = 0.0

    def step(self, t_s: float, counts: int, drive: float = 0.0) -> ThermalReason:
        """Return what is wrong with a reading at `t_s`, or NONE.

        Args:
            t_s: time of the reading, s.
            counts: 0..4095.
            drive: heater drive in force, -1..1; a driven plate cannot stay on one count.
        """
        before, before_s = self._counts, self._t_s
        self._counts, self._t_s = counts, t_s
        if before is None or counts != before or abs(drive) < 0.3:
            self._since_s = t_s
        if not counts > 0:
            return ThermalReason.SENSOR_SHORTED
        if not counts < COUNT_MAX:
            return ThermalReason.SENSOR_OPEN
        if before is not None and t_s > before_s:
            change_k = abs(ssr_c(counts) - ssr_c(before))
            # the floor is ten times the noise of one reading
            if change_k > max(self.MAX_RATE_K_S * (t_s - before_s), 0.3):
                return ThermalReason.SENSOR_JUMPS
        if t_s - self._since_s > FROZEN_S:
            return ThermalReason.SENSOR_FROZEN
        return ThermalReason.NONE
