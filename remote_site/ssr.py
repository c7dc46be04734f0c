"""Silicon spreading resistor: ADC counts to temperature, and whether a reading can be true.

The read-out is linear in resistance: count 0 is the resistance at 0 C, count 4095 that at 60 C.
"""

import math

R25_OHM = 1000.0
LINEAR_PER_K = 7.874e-3
QUADRATIC_PER_K2 = 1.874e-5
"""R(T) = R25 (1 + a dT + b dT^2) with dT = T - 25 C; typical of the KTY81 class."""
FULL_SCALE = 4095
LOW_C, HIGH_C = 0.0, 60.0
FROZEN_S = 1.0
"""A plate being heated that repeats one count for this long is not being measured, s."""


def resistance_ohm(temperature_c: float) -> float:
    """Resistance at a temperature in C, Ohm."""
    d = temperature_c - 25.0
    return R25_OHM * (1.0 + LINEAR_PER_K * d + QUADRATIC_PER_K2 * d * d)


_LOW_OHM = resistance_ohm(LOW_C)
_OHM_PER_COUNT = (resistance_ohm(HIGH_C) - _LOW_OHM) / FULL_SCALE


def counts_to_c(counts: int) -> float:
    """Temperature of a reading of 0..4095 counts, C."""
    ratio = (_LOW_OHM + counts * _OHM_PER_COUNT) / R25_OHM - 1.0
    root = math.sqrt(LINEAR_PER_K * LINEAR_PER_K + 4.0 * QUADRATIC_PER_K2 * ratio)
    return 25.0 + 2.0 * ratio / (LINEAR_PER_K + root)


def c_to_counts(temperature_c: float) -> int:
    """Counts that the read-out gives at a temperature in C, held to 0..4095."""
    counts = round((resistance_ohm(temperature_c) - _LOW_OHM) / _OHM_PER_COUNT)
    return min(max(counts, 0), FULL_SCALE)


class SsrPlausibility:
    """Tells a broken sensor from a reading: open, short, jumping or frozen while driven."""

    __slots__ = ("_counts", "_since_s", "_t_s")

    MAX_RATE_K_S = 40.0
    """Faster than any contact can change the plate, K/s."""

    def __init__(self) -> None:
        self._counts: int | None = None
        self._t_s = 0.0
        self._since_s = 0.0

    def step(self, t_s: float, counts: int, drive: float = 0.0) -> str | None:
        """Return what is wrong with a reading at `t_s`, or None.

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
            return "thermal sensor shorted"
        if not counts < FULL_SCALE:
            return "thermal sensor open"
        if before is not None and t_s > before_s:
            change_k = abs(counts_to_c(counts) - counts_to_c(before))
            # the floor is ten times the noise of one reading
            if change_k > max(self.MAX_RATE_K_S * (t_s - before_s), 0.3):
                return "thermal sensor jumps"
        if t_s - self._since_s > FROZEN_S:
            return "thermal sensor frozen"
        return None
