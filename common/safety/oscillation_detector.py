"""Detects an oscillation of a finger's force that only an unstable loop can cause.

A cycle is a rise and a fall of the force by SWING_N each; noise, tremor on a hard wall and grooves cause smaller
changes. Successive cycles belong to one oscillation if they have similar periods and the amplitude does not decay. The
ringing after an impact decays, and the next impact comes after a different time.

Two criteria distinguish an unstable loop from a hand:

- Frequency. No hand taps more than eight times a second; SWING_CYCLES within SWING_S are twelve a second.
- Energy. A hand that taps or presses in rhythm supplies the energy that the contact absorbs. An unstable loop gets its
  energy through the port, so the limit on energy acts in every cycle.
"""

import math
from collections import deque

from common.faults.fault import Fault, FaultCode
from common.limits import SWING_CYCLES, SWING_N, SWING_S, SWING_SLOW_CYCLES, SWING_SLOW_HZ

SAME_PERIOD, SAME_SWING = 2.0, 0.5
"""Maximum ratio of the periods of two successive cycles of one oscillation, and minimum ratio of their amplitudes."""


class OscillationDetector:
    """Detects an oscillation of one finger's force."""

    def __init__(self) -> None:
        self._peaks_s: deque[float] = deque(maxlen=SWING_CYCLES + 1)
        """Times of the peaks of the present oscillation, s; the first is the start of its first cycle."""
        self.restart()

    def restart(self) -> None:
        """Discard earlier cycles, after the gate has released the force or a person has cleared a fault."""
        self._rising = True
        self._extreme_n, self._extreme_s = -math.inf, -math.inf
        """Highest force of the present rise or lowest of the present fall, N, and its time, s."""
        self._trough_n = 0.0
        self._peaks_s.clear()
        self._peaks_s.append(-math.inf)
        self._period_s, self._swing_n = math.inf, 0.0
        """Period, s, and amplitude, N, of the last cycle."""
        self._fed = False
        self._fed_cycles = 0

    def step(self, t_s: float, force_n: float, fed: bool) -> Fault | None:
        """Return a fault if the force oscillates, else None; `fed` if the limit on the port's energy acts now."""
        self._fed = self._fed or fed
        beyond_n = force_n - self._extreme_n if self._rising else self._extreme_n - force_n
        if beyond_n > 0.0:
            self._extreme_n, self._extreme_s = force_n, t_s
            return None
        if beyond_n > -SWING_N:
            return None
        found = self._cycle() if self._rising else None
        if not self._rising:
            self._trough_n = self._extreme_n
        self._rising = not self._rising
        self._extreme_n, self._extreme_s = force_n, t_s
        return found

    def _cycle(self) -> Fault | None:
        """Count the cycle that ends with this peak; return a fault if it completes an oscillation."""
        peaks_s, before_s = self._peaks_s, self._period_s
        period_s, swing_n = self._extreme_s - peaks_s[-1], self._extreme_n - self._trough_n
        # A period across a clock that was set back is not positive and does not count.
        same = 0.0 < before_s <= SAME_PERIOD * period_s <= SAME_PERIOD * SAME_PERIOD * before_s
        if not (same and swing_n >= SAME_SWING * self._swing_n):
            last_s = peaks_s[-1]
            peaks_s.clear()
            peaks_s.append(last_s)
            self._fed_cycles = 0
        self._period_s, self._swing_n = period_s, swing_n
        peaks_s.append(self._extreme_s)
        fed = self._fed and period_s * SWING_SLOW_HZ <= 1.0
        self._fed_cycles = self._fed_cycles + 1 if fed else 0
        self._fed = False
        if len(peaks_s) > SWING_CYCLES and peaks_s[-1] - peaks_s[0] <= SWING_S:
            return _swings(SWING_CYCLES / (peaks_s[-1] - peaks_s[0]), swing_n)
        if self._fed_cycles >= SWING_SLOW_CYCLES:
            return _swings(1.0 / period_s, swing_n)
        return None


def _swings(rate_hz: float, swing_n: float) -> Fault:
    return Fault(FaultCode.FORCE_SWINGS, value=swing_n, rate_hz=rate_hz)
