"""Which ticks are late, and so leave the slow part of identification to a later one.

Lateness is seen in the ticks' own times, which a recording has: a replay postpones what the session postponed.
"""

LATE = 1.5
"""A tick is late that begins more than so many periods after the one before."""
POSTPONED_S = 0.2
"""No solution is postponed for longer than this: on a machine that is always late there are five a second, s."""


class LateTicks:
    """Compares each tick with the one before. Pure: times, s, in."""

    def __init__(self, period_s: float) -> None:
        """Take the time from one tick to the next, s."""
        self._longest_s = LATE * period_s
        self._before_s: float | None = None

    def step(self, t_s: float) -> bool:
        """Whether the tick that begins at `t_s` is late; the first is not."""
        late = self._before_s is not None and t_s - self._before_s > self._longest_s
        self._before_s = t_s
        return late
