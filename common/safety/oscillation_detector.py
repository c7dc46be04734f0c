"""Does a finger's force swing to and fro as only an unstable loop makes it?

A cycle is a rise and a fall of the force by SWING_N each; noise, tremor on a hard wall and grooves make less. It
belongs to the same swinging as the one before when it lasts about as long and has not died down: what rings after an
impact does, and the next impact comes at another time. What tells a loop that has become unstable from a hand is then

- how fast it is: no hand taps more than eight times a second, and SWING_CYCLES within SWING_S are twelve;
- or else energy: whether it taps or presses in rhythm, a hand itself puts in what the contact takes. A loop that swings
  by itself is fed through the port, and there the limit on energy has to act in every cycle.
"""

import math
from collections import deque

from common.faults.fault import Fault, FaultCode
from common.limits import SWING_CYCLES, SWING_N, SWING_S, SWING_SLOW_CYCLES, SWING_SLOW_HZ

SAME_PERIOD, SAME_SWING = 2.0, 0.5
"""A cycle at most so many times as long or as short as the one before, and not smaller than so much of it, goes on."""


class OscillationDetector:
    """Watches one finger's force."""

    __slots__ = (
        "_extreme_n",
        "_extreme_s",
        "_fed",
        "_fed_cycles",
        "_peaks_s",
        "_period_s",
        "_rising",
        "_swing_n",
        "_trough_n",
    )

    def __init__(self) -> None:
        self._peaks_s: deque[float] = deque(maxlen=SWING_CYCLES + 1)
        """Of the same swinging; the first is where its first cycle began."""
        self.begin_anew()

    def begin_anew(self) -> None:
        """Count no swing from before: the gate itself has let the force go, or a person has cleared a fault."""
        self._rising = True
        self._extreme_n, self._extreme_s = -math.inf, -math.inf
        """Highest force since it rises, or lowest since it falls, and when."""
        self._trough_n = 0.0
        self._peaks_s.clear()
        self._peaks_s.append(-math.inf)
        self._period_s, self._swing_n = math.inf, 0.0
        """Of the last cycle."""
        self._fed = False
        self._fed_cycles = 0

    def step(self, t_s: float, force_n: float, fed: bool) -> Fault | None:
        """Return that it swings, or None.

        Args:
            t_s: time, s.
            force_n: the force, N.
            fed: whether the limit on the port's energy acts now.
        """
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
        """Count the cycle that ends with this peak."""
        peaks_s, before_s = self._peaks_s, self._period_s
        period_s, swing_n = self._extreme_s - peaks_s[-1], self._extreme_n - self._trough_n
        # No period of a clock that was set back is one.
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
