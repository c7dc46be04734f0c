"""Estimates the spacing of a surface's grooves from the places of single impulses along the path.

A finger that turns crosses the same groove again. This gap is not the spacing, and does not count.
"""

import math
from collections import deque
from dataclasses import dataclass
from statistics import median

REGULAR = 0.15
"""Maximum scatter of the gaps of regular grooves, as a fraction of the spacing."""
STRAIGHT = 0.5
"""Minimum distance of two grooves on the bench, as a fraction of the path between them; a shorter path has a turn."""
LEAST_SD_M = 1e-6
"""Smallest stated standard deviation of a spacing, m; its value is stated in steps of this length."""


@dataclass(frozen=True, slots=True)
class Period:
    """Spacing of grooves and its standard deviation, m, and standard deviation over mean of single gaps.

    `irregularity` is the deviation that two thirds of the gaps do not exceed. Half of them would be one of two gaps
    that alternate.

    An error of the speed by a factor changes the spacing and its deviation by the same factor. It does not change
    `irregularity` and `irregular`.
    """

    period_m: float
    period_sd_m: float
    irregularity: float

    @property
    def irregular(self) -> bool:
        """Whether the grooves are too irregular for a period."""
        return self.irregularity > REGULAR


class GroovePeriod:
    """Estimator of the distance between impulses along the path."""

    FEWEST = 3
    """Minimum number of gaps for an estimate."""
    LONGEST_M = 0.030
    """Longest gap that counts, m."""
    MOST = 64
    """Number of the latest gaps that are kept of a recording."""
    ENDED = 3.5
    """Length of path without a groove after which the grooves have ended, in periods."""

    def __init__(self, most: int = MOST) -> None:
        """Keep this number of the latest gaps; after this many, nothing is left of an earlier grating."""
        self._last: tuple[float, tuple[float, float]] | None = None
        self._gaps_m: deque[float] = deque(maxlen=most)
        self._without_m = 0.0

    def stroke(self, way_m: float) -> None:
        """Take a further length of path, m, before its grooves; forget the grooves if they have ended."""
        self._without_m += way_m
        if self._gaps_m and self._without_m > self.ENDED * median(self._gaps_m):
            self._gaps_m.clear()
            self.interrupt()

    def groove(self, place_m: float, at_m: tuple[float, float]) -> None:
        """Take a groove crossed at this place of the path, m, ascending, and at this place on the bench, m."""
        if self._last is not None:
            last_m, last_at_m = self._last
            gap_m = place_m - last_m
            if gap_m <= self.LONGEST_M and math.dist(at_m, last_at_m) >= STRAIGHT * gap_m:
                self._gaps_m.append(gap_m)
        self._last = place_m, at_m
        self._without_m = 0.0

    def interrupt(self) -> None:
        """Interrupt the path; the next gap starts at the next groove."""
        self._last = None

    def estimate(self) -> Period | None:
        """Return the median spacing with its standard error; None before FEWEST gaps."""
        gaps_m = self._gaps_m
        if len(gaps_m) < self.FEWEST:
            return None
        count, middle_m = len(gaps_m), median(gaps_m)
        off_m = sorted(abs(gap_m - middle_m) for gap_m in gaps_m)
        sd_m, scatter_m = 1.4826 * off_m[count // 2], 1.0338 * off_m[2 * count // 3]
        period_sd_m = max(LEAST_SD_M, 1.25 * sd_m / math.sqrt(count))
        return Period(middle_m, period_sd_m, scatter_m / max(middle_m, 1e-6))
