"""How stiff a wall the loop may show as it really runs: one that stands still again and again holds each force longer.

The bound of the sampled wall has half of the period in it because a force is half a period old on average while it is
held. So the period that counts is the mean over the time, not over the ticks: one pause in a second is felt by nobody,
and a loop, or a device, that works for 10 ms in every 40 shows a softer wall for as long as it does.
"""

import math
from dataclasses import replace

from operator_site.safety.sampled_wall import SampledWall

SETTLES_S = 0.25
SLACK = 1.5
"""Up to so many periods the loop keeps its time."""
LONGEST_S = 0.1
"""A longer pause lets every force go."""


class LoopStiffness:
    """Watches the times of a loop that answers each new height with a force.

    Attributes:
        wall: what can be shown now.
    """

    def __init__(self, wall: SampledWall) -> None:
        """Take a loop that keeps the period of `wall` until it is seen that it does not."""
        self._kept = self.wall = wall
        self._held_s = wall.period_s
        self._t_s = self._height_s = math.nan

    def step(self, t_s: float, height_s: float) -> None:
        """Take one tick.

        Args:
            t_s: time, s.
            height_s: when the heights that it answers were measured, s; the same again is no new answer.
        """
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
