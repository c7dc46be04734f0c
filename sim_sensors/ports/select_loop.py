"""Event loop of the simulators: handle bytes as soon as they arrive, until the next tick is due.

`select.select` waits with microsecond resolution; polls and event loops with millisecond resolution would be late.
"""

import select
import time
from collections.abc import Callable, Iterator

from common.runtime.periodic_loop import PeriodicLoop

Handler = Callable[[float], None]


class SelectLoop:
    """Watch file descriptors and call each one's handler with the time at which it became readable."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self.now = now
        self._handlers: dict[int, Handler] = {}
        self._descriptors: list[int] = []

    def watch(self, descriptor: int, handler: Handler) -> None:
        """Call `handler(now_s)` whenever the descriptor can be read."""
        self._handlers[descriptor] = handler
        self._descriptors = list(self._handlers)

    def forget(self, descriptor: int) -> None:
        """Stop watching a descriptor; call this before closing it."""
        self._handlers.pop(descriptor, None)
        self._descriptors = list(self._handlers)

    def ticks(self, periodic: PeriodicLoop, stop: Callable[[], bool]) -> Iterator[float]:
        """Yield the time of each tick of a loop that waits with `serve`, until `stop()`."""
        while not stop():
            if periodic.wait() > periodic.period_s / 4.0:
                self.serve(0.0)  # the loop did not wait, so nothing was handled since the last tick
            yield self.now()

    def serve(self, seconds: float) -> None:
        """Handle readable descriptors for `seconds`; with 0, only those readable already."""
        deadline = self.now() + seconds
        while True:
            wait_s = max(0.0, deadline - self.now())
            ready, _, _ = select.select(self._descriptors, [], [], wait_s)
            now_s = self.now()
            for descriptor in ready:
                handler = self._handlers.get(descriptor)
                if handler is not None:  # an earlier handler may have closed it
                    handler(now_s)
            if now_s >= deadline:
                return
