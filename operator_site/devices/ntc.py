"""Checks the NTC thermistors of a fingertip module, and the rate of change of the plate's temperature."""

import math
from collections import deque
from typing import NamedTuple

from common.buses.thermometry import ntc_c
from common.faults.fault import FaultCode

SHORT_BELOW = 100
"""Counts up to which the thermistor is shorted (about 143 C)."""
OPEN_ABOVE = 3995
"""Counts from which on the thermistor is open (about -43 C)."""
RATE_LIMIT_K_S = 8.0
"""Maximum rate of change, K/s, twice the plate's; a faster change is a fault of the sensor."""
RATE_WINDOW_S = 0.15
"""Time over which the rate is measured, s, so that noise or delay of one sample is no fault."""
SILENCE_S = 0.03
"""Maximum pause within a rate measurement, s; after a longer one, delayed readings arrive together."""
HEAP_S = 0.002
"""Maximum interval of readings that were delayed, s; only the time of the last one is true."""


def ntc_fault(counts: int, short: FaultCode, opened: FaultCode) -> FaultCode | None:
    """Return which of two faults a thermistor's counts show; None when they are a temperature."""
    if counts <= SHORT_BELOW:
        return short
    return opened if counts >= OPEN_ABOVE else None


class PlateReading(NamedTuple):
    """A plate's temperature, C; NaN with the fault of its sensor."""

    plate_c: float
    fault: FaultCode | None


class PlateSensor:
    """Sensor of one plate: `step` for each new reading."""

    def __init__(self) -> None:
        self._recent: deque[tuple[float, float]] = deque()

    def step(self, t_s: float, counts: int) -> PlateReading:
        """Check the reading taken at `t_s`, s."""
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
