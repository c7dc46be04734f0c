"""Distance between the grooves of a surface, from single impulse flags."""

import math
from collections import deque
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Period:
    """Distance of grooves and its standard deviation, m, and standard deviation over mean of single gaps."""

    period_m: float
    period_sd_m: float
    irregularity: float


class GroovePeriod:
    """Distance between impulse flags along the stroke."""

    FEWEST = 3
    LONGEST_M = 0.030

    __slots__ = ("_gaps_m", "_travelled_m")

    def __init__(self) -> None:
        self._travelled_m: float | None = None
        self._gaps_m: deque[float] = deque(maxlen=64)

    def move(self, distance_m: float) -> None:
        """The finger moved by this path length, m, without a flag."""
        if self._travelled_m is not None:
            self._travelled_m += distance_m

    def flag(self) -> None:
        """A groove was crossed here."""
        if self._travelled_m is not None and self._travelled_m <= self.LONGEST_M:
            self._gaps_m.append(self._travelled_m)
        self._travelled_m = 0.0

    def interrupt(self) -> None:
        """The stroke ended: the next gap starts anew."""
        self._travelled_m = None

    def estimate(self) -> Period | None:
        """Median distance with its standard error; None before FEWEST gaps."""
        n = len(self._gaps_m)
        if n < self.FEWEST:
            return None
        gaps = sorted(self._gaps_m)
        median = gaps[n // 2] if n % 2 else 0.5 * (gaps[n // 2 - 1] + gaps[n // 2])
        deviations = sorted(abs(gap - median) for gap in gaps)
        sd = 1.4826 * deviations[n // 2]
        return Period(median, 1.25 * sd / math.sqrt(n), sd / max(median, 1e-6))
