"""Is what a tick decided still new when it is sent? A process that was stopped in a tick finishes it on waking."""

import math
import time
from collections.abc import Callable

from common.ladder import TICK_AGE_S


class TickAge:
    """Asked before each device of a site is written to.

    What is not sent is not missed: a device keeps its last command until its own time-out, which is longer, and the
    next tick begins at once.

    Attributes:
        began_s: the present tick's time, s; -inf before the first.
        held_back: ticks of which something was not sent.
    """

    def __init__(self, clock_s: Callable[[], float] = time.monotonic) -> None:
        """Compare with `clock_s`, the clock that ticks have their time from."""
        self.began_s = -math.inf
        self.held_back = 0
        self._clock_s = clock_s
        self._counted = False

    def begin(self, t_s: float) -> None:
        """A tick begins, at this time."""
        self.began_s = t_s
        self._counted = False

    def in_time(self) -> bool:
        """Whether what the tick decided may still be sent."""
        if self._clock_s() - self.began_s <= TICK_AGE_S:
            return True
        self.held_back += not self._counted
        self._counted = True
        return False
