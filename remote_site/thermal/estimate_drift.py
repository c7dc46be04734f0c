"""Finds touches whose estimated temperature moves further than its uncertainty allows.

Later readings refine an estimate if the model of the touch holds. If not, they pull it away: the model has a thick
object, and a thin one is warm throughout after some seconds. Two estimates are compared as in a specification test
(Hausman 1978, Econometrica 46, 1251).
"""

import math

FROM_S = 1.5
"""Earliest time after contact of an estimate that later ones are compared with, s; earlier ones depend on the prior."""
EVERY_S = 0.5
"""Interval between two such estimates, s."""
MOST_SD = 4.0
"""Largest difference of two estimates, in standard deviations of both together."""
HELD_S = 0.3
"""Minimum duration of a larger difference, s; a single solution can be far off after the readings are summed again."""


class EstimateDrift:
    """Estimates of one touch, or of all fingers on one object."""

    def __init__(self) -> None:
        self._earlier: list[tuple[float, float]] = []
        self._near_s, self._next_s = 0.0, FROM_S

    def step(self, since_s: float, object_c: float, object_c_sd: float) -> bool:
        """Take an estimate, C, and its SD, K; return whether they have been too far from an earlier one for HELD_S."""
        if all(abs(object_c - c) <= MOST_SD * math.hypot(object_c_sd, sd) for c, sd in self._earlier):
            self._near_s = since_s
        if since_s >= self._next_s:
            self._earlier.append((object_c, object_c_sd))
            self._next_s = since_s + EVERY_S
        return since_s - self._near_s >= HELD_S - 1e-9
