"""Deadband: sends a packet when the far side would perceive the change, and at least at the refresh interval.

Without changes a packet follows every 12 ms. The far side sees a gap of more than 0.1 s only after eight lost
refreshes in a row. With a fifth of all packets lost at random this occurs 0.6 times an hour. A change is repeated in
the next tick, so that one lost packet leaves no error.
"""

import math

from common.timing.timeouts import REFRESH_S

REPEATS = 1
"""Number of repetitions of a change in the following ticks."""
_EARLY = 0.75
"""Share of a period: a tick less than this before the refresh sends at once."""


class Deadband:
    """Decides for each tick whether to send. The caller decides whether a change is perceptible.

    Attributes:
        spared: number of ticks without a packet.
    """

    __slots__ = ("_again", "_quiet_s", "_repeats", "_sent_s", "spared")

    def __init__(self, period_s: float, repeats: int = REPEATS) -> None:
        """Decide for a loop with this period, s, and repeat each change `repeats` times."""
        self._quiet_s = REFRESH_S - _EARLY * period_s
        self._repeats = repeats
        self._sent_s = -math.inf
        self._again = 0
        self.spared = 0

    def step(self, t_s: float, felt: bool) -> bool:
        """Return whether to send at `t_s`, s; `felt` is whether the far side would perceive the change."""
        if felt:
            self._again = 1 + self._repeats
        if not self._again and 0.0 <= t_s - self._sent_s <= self._quiet_s:  # a clock that was set back sends
            self.spared += 1
            return False
        self._again = max(0, self._again - 1)
        self._sent_s = t_s
        return True
