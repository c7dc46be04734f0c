"""Is what a tick decided still new when it is sent? A process that was stopped in a tick finishes it on waking."""

import math
from collections.abc import Callable

from common.timing.standstill import HostClock
from common.timing.timeouts import TICK_AGE_S


class TickAge:
    """Asked before each device of a site is written to.

    What is not sent is not missed: a device keeps its last command until its own time-out, which is longer, and the
    next tick begins at once.

    Attributes:
        clock: of the site; ticks have their time from it.
        began_s: the present tick's time, s; -inf before the first.
        stood_still_ns: by how much the present tick's devices have put the clock forward, ns.
        held_back: ticks of which something was not sent.
    """

    def __init__(self, clock: HostClock | None = None, unread_s: Callable[[], float] = lambda: 0.0) -> None:
        """Begin before the first tick.

        Args:
            clock: of the site.
            unread_s: how long devices have taken for the reports that wait to be read, s. After a standstill of the
                host and its clock in the middle of a tick they are the only sign of it.
        """
        self.clock = HostClock() if clock is None else clock
        self.began_s = -math.inf
        self.stood_still_ns = 0
        self.held_back = 0
        self._unread_s = unread_s
        self._looked = False
        self._old = True

    def begin(self, t_s: float) -> None:
        """A tick begins, at this time."""
        self.began_s = t_s
        self.stood_still_ns = 0
        self._looked = self._old = False

    def stood_still(self, seconds: float) -> None:
        """Devices show that the clock stood still for this long, s, before they were read; 0 where they do not."""
        if seconds > 0.0:
            self.stood_still_ns = self.clock.put_forward(seconds)
            self.began_s += self.stood_still_ns * 1e-9

    def in_time(self) -> bool:
        """Whether what the tick decided may still be sent."""
        if not self._old:
            unread_s = 0.0 if self._looked else self._unread_s()
            self._looked = True
            self._old = self.clock.now_s() - self.began_s > TICK_AGE_S or unread_s > TICK_AGE_S
            self.held_back += self._old
        return not self._old
