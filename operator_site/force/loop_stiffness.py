"""Limits the displayed stiffness by the loop's measured period, because a slow loop holds each force longer.

The bound of the sampled wall contains half of the period, the mean age of a held force. The relevant period is
therefore the mean over time instead of the mean over ticks. One pause in a second is imperceptible. A loop or device
that works for only 10 ms in every 40 ms displays a softer wall until it recovers.
"""

import math
from dataclasses import replace

from operator_site.safety.sampled_wall import SampledWall

SETTLES_S = 0.25
"""Time constant of the mean period, s."""
SLACK = 1.5
"""Largest ratio of mean to nominal period that leaves the wall unchanged."""
LONGEST_S = 0.1
"""Longest pause that enters the mean, s; a longer one releases all forces."""


class LoopStiffness:
    """Measures the period of a loop that answers each new height with a force.

    Attributes:
        wall: bound of the walls that the loop can display passively at present.
    """

    def __init__(self, wall: SampledWall) -> None:
        """Begin with the nominal period of `wall`."""
        self._kept = self.wall = wall
        self._held_s = wall.period_s
        self._t_s = self._height_s = math.nan

    def step(self, t_s: float, height_s: float) -> None:
        """Take one tick, which answers heights measured at `height_s`, s; a repeated time is ignored."""
        if height_s == self._height_s:
            return
        passed_s = t_s - self._t_s
        self._t_s, self._height_s = t_s, height_s
        if not 0.0 < passed_s <= LONGEST_S:
            return
        self._held_s += min(1.0, passed_s / SETTLES_S) * (passed_s - self._held_s)
        if self._held_s > SLACK * self._kept.period_s:
            self.wall = replace(self._kept, period_s=self._held_s)
        else:
            self.wall = self._kept
