"""Whether this tick is worth a packet: when the far side would feel the difference, and often enough to be believed.

A quiet finger costs a refresh every 12 ms and nothing else. Where a fifth of all packets is lost, each by chance, eight
refreshes in a row must be before the far side takes it for dead (a gap of more than 0.1 s): 0.6 times in an hour. What
has changed is told again in the next tick, so that one lost packet leaves no error behind.
"""

import math

from common.timing.timeouts import REFRESH_S

REPEATS = 1
"""How often a change is told again, in the ticks that follow."""
_EARLY = 0.75
"""Of a period: a tick that close to the refresh does not wait for the next one."""


class Deadband:
    """Counts and decides, tick by tick; what is felt is for its owner to say.

    Attributes:
        spared: ticks that were not worth a packet.
    """

    __slots__ = ("_again", "_quiet_s", "_repeats", "_sent_s", "spared")

    def __init__(self, period_s: float, repeats: int = REPEATS) -> None:
        """Decide for a loop with this period, s, and tell each change again so often."""
        self._quiet_s = REFRESH_S - _EARLY * period_s
        self._repeats = repeats
        self._sent_s = -math.inf
        self._again = 0
        self.spared = 0

    def step(self, t_s: float, felt: bool) -> bool:
        """Whether to send at `t_s`, s, a packet that the far side would feel the lack of, or would not."""
        if felt:
            self._again = 1 + self._repeats
        if not self._again and 0.0 <= t_s - self._sent_s <= self._quiet_s:  # a clock set back sends
            self.spared += 1
            return False
        self._again = max(0, self._again - 1)
        self._sent_s = t_s
        return True
