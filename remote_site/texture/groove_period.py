"""Distance between the grooves of a surface, from the places of single impulses along the way."""

import math
from collections import deque
from dataclasses import dataclass

REGULAR = 0.15
"""Grooves whose gaps scatter by less than this part of their distance are regular."""


@dataclass(frozen=True, slots=True)
class Period:
    """Distance of grooves and its standard deviation, m, and standard deviation over mean of single gaps.

    A speed that is wrong by a factor makes the distance and its deviation wrong by the same factor; `irregularity`
    and `irregular` it leaves as they are.
    """

    period_m: float
    period_sd_m: float
    irregularity: float

    @property
    def irregular(self) -> bool:
        """Whether the grooves have no period of which a person could speak."""
        return self.irregularity > REGULAR


class GroovePeriod:
    """Distance between impulses along the way."""

    FEWEST = 3
    LONGEST_M = 0.030
    MOST = 64
    """Gaps needed, the longest that counts, and how many of the latest are kept."""

    __slots__ = ("_gaps_m", "_last_m")

    def __init__(self) -> None:
        self._last_m: float | None = None
        self._gaps_m: deque[float] = deque(maxlen=self.MOST)

    def groove(self, place_m: float) -> None:
        """A groove was crossed at this place of the way, m, ascending."""
        if self._last_m is not None and place_m - self._last_m <= self.LONGEST_M:
            self._gaps_m.append(place_m - self._last_m)
        self._last_m = place_m

    def interrupt(self) -> None:
        """The way was interrupted: the next gap starts anew."""
        self._last_m = None

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
