"""The simulators' waiting: bytes are handled the moment they come, until the next tick is due.

`select.select` waits to the microsecond; polls and event loops that count milliseconds would be late.
"""

import select
import time
from collections.abc import Callable

Handler = Callable[[float], None]


class SelectLoop:
    """Watches file descriptors; each has a handler that is called with the time at which it became readable."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self.now = now
        self._handlers: dict[int, Handler] = {}
        self._descriptors: list[int] = []

    def watch(self, descriptor: int, handler: Handler) -> None:
        """Call `handler(now_s)` whenever the descriptor can be read."""
        self._handlers[descriptor] = handler
        self._descriptors = list(self._handlers)

    def forget(self, descriptor: int) -> None:
        """Watch it no longer; do this before closing it."""
        self._handlers.pop(descriptor, None)
        self._descriptors = list(self._handlers)

    def serve(self, seconds: float) -> None:
        """Handle what comes for `seconds`; with 0, what is there already."""
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
