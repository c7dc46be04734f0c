"""Bytes on their way to a reader that may be slow: bounded, and the oldest are dropped first."""

from collections import deque
from collections.abc import Callable


class Backlog:
    """Messages not yet written.

    Attributes:
        dropped: messages thrown away because the reader was too slow.
    """

    def __init__(self, most_bytes: int) -> None:
        self.dropped = 0
        self._most_bytes = most_bytes
        self._waiting: deque[bytes] = deque()
        self._bytes = 0
        self._begun = False

    def push(self, message: bytes) -> None:
        """Add a message; a message of which a part is written already is never dropped."""
        self._waiting.append(message)
        self._bytes += len(message)
        while self._bytes > self._most_bytes and len(self._waiting) > 1 + self._begun:
            oldest = self._waiting[1] if self._begun else self._waiting[0]
            del self._waiting[1 if self._begun else 0]
            self._bytes -= len(oldest)
            self.dropped += 1

    def pass_on(self, message: bytes, send: Callable[[bytes], int]) -> None:
        """Add a message and write as much as goes without waiting.

        Raises:
            OSError: as `write`.
        """
        if not self._waiting:
            try:
                taken = send(message)
            except (BlockingIOError, InterruptedError):
                taken = 0
            if taken == len(message):
                return
            message, self._begun = message[taken:], taken > 0
        self.push(message)
        self.write(send)

    def write(self, send: Callable[[bytes], int]) -> None:
        """Write as much as goes without waiting. `send` returns how many bytes it took.

        Raises:
            OSError: what `send` raises, except that it would have to wait.
        """
        while self._waiting:
            message = self._waiting[0]
            try:
                taken = send(message)
            except (BlockingIOError, InterruptedError):
                return
            self._bytes -= taken
            self._begun = taken < len(message)
            if self._begun:
                self._waiting[0] = message[taken:]
            else:
                self._waiting.popleft()
