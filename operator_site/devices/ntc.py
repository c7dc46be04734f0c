"""NTC thermistors of a fingertip module: whether they are whole, and whether to believe what the plate's says."""

import math
from collections import deque
from typing import NamedTuple

from common.buses.thermometry import ntc_c
from common.faults.fault import FaultCode

SHORT_BELOW = 100
OPEN_ABOVE = 3995
"""Counts outside are a broken wire or a short, not a temperature (about 143 C and -43 C)."""
RATE_LIMIT_K_S = 8.0
"""Twice what the plate can do: a faster change is a fault of the sensor."""
RATE_WINDOW_S = 0.15
"""Over which the rate is taken, so that noise of one sample, or its late arrival, is not taken for one."""
SILENCE_S = 0.03
"""After a longer pause readings arrive in a heap, too late: no rate can be told across it."""
HEAP_S = 0.002
"""Readings that arrive this close together were waiting; only the last one's time is true."""


def ntc_fault(counts: int, short: FaultCode, opened: FaultCode) -> FaultCode | None:
    """Which of two faults makes a thermistor's counts no temperature; None when they are one."""
    if counts <= SHORT_BELOW:
        return short
    return opened if counts >= OPEN_ABOVE else None


class PlateReading(NamedTuple):
    """A plate's temperature; NaN together with the fault where there is none."""

    plate_c: float
    fault: FaultCode | None


class PlateSensor:
    """One plate's sensor over time: `step` for each new reading."""

    def __init__(self) -> None:
        self._recent: deque[tuple[float, float]] = deque()

    def step(self, t_s: float, counts: int) -> PlateReading:
        """Judge the reading taken at `t_s`."""
        broken = ntc_fault(counts, FaultCode.PLATE_THERMISTOR_SHORT, FaultCode.PLATE_THERMISTOR_OPEN)
        if broken is not None:
            return self._refuse(broken)
        plate_c = ntc_c(counts)
        recent = self._recent
        if recent and not 0.0 <= t_s - recent[-1][0] <= SILENCE_S:
            recent.clear()
        elif recent and t_s - recent[-1][0] < HEAP_S:
            recent.pop()
        recent.append((t_s, plate_c))
        while t_s - recent[0][0] > RATE_WINDOW_S + SILENCE_S:
            recent.popleft()
        span_s = t_s - recent[0][0]
        if span_s >= RATE_WINDOW_S - 1e-9 and abs(plate_c - recent[0][1]) > RATE_LIMIT_K_S * span_s:
            return PlateReading(math.nan, FaultCode.PLATE_THERMISTOR_JUMPS)
        return PlateReading(plate_c, None)

    def _refuse(self, fault: FaultCode) -> PlateReading:
        self._recent.clear()
        return PlateReading(math.nan, fault)
