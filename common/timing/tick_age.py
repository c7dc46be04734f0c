"""Checks that a tick's decision is still new when it is sent; a stopped process finishes its tick on waking."""

import math
from collections.abc import Callable

from common.timing.standstill import HostClock
from common.timing.timeouts import TICK_AGE_S


class TickAge:
    """Checks the age of a tick's decision before each write to a device of a site.

    A withheld command is no loss: a device keeps its last command until its own time-out, which is longer, and the
    next tick starts at once.

    Attributes:
        clock: clock of the site, and of its ticks.
        began_s: start of the present tick, s; -inf before the first.
        stood_still_ns: time by which the present tick's devices have set the clock forward, ns.
        held_back: number of ticks of which a command was withheld.
    """

    def __init__(self, clock: HostClock | None = None, unread_s: Callable[[], float] = lambda: 0.0) -> None:
        """Start before the first tick.

        Args:
            clock: clock of the site.
            unread_s: returns the device time that unread reports cover, s. It is the only sign of a standstill of the
                host and its clock in the middle of a tick.
        """
        self.clock = HostClock() if clock is None else clock
        self.began_s = -math.inf
        self.stood_still_ns = 0
        self.held_back = 0
        self._unread_s = unread_s
        self._looked = False
        self._old = True

    def begin(self, t_s: float) -> None:
        """Start a tick at this time, s."""
        self.began_s = t_s
        self.stood_still_ns = 0
        self._looked = self._old = False

    def stood_still(self, seconds: float) -> None:
        """Set the clock forward by a standstill, s, that devices show from before they were read; 0 has no effect."""
        if seconds > 0.0:
            self.stood_still_ns = self.clock.put_forward(seconds)
            self.began_s += self.stood_still_ns * 1e-9

    def in_time(self) -> bool:
        """Return whether the tick's decision may still be sent."""
        if not self._old:
            unread_s = 0.0 if self._looked else self._unread_s()
            self._looked = True
            self._old = self.clock.now_s() - self.began_s > TICK_AGE_S or unread_s > TICK_AGE_S
            self.held_back += self._old
        return not self._old
