"""Bounded output queue for a slow reader; the oldest messages are dropped first."""

from collections import deque
from collections.abc import Callable


class Backlog:
    """Queue of messages not yet written.

    Attributes:
        dropped: number of messages discarded because the reader was too slow.
    """

    def __init__(self, most_bytes: int) -> None:
        self.dropped = 0
        self._most_bytes = most_bytes
        self._waiting: deque[bytes] = deque()
        self._bytes = 0
        self._begun = False

    def push(self, message: bytes) -> None:
        """Append a message and drop the oldest above the limit; a partly written message is never dropped."""
        self._waiting.append(message)
        self._bytes += len(message)
        while self._bytes > self._most_bytes and len(self._waiting) > 1 + self._begun:
            oldest = self._waiting[1] if self._begun else self._waiting[0]
            del self._waiting[1 if self._begun else 0]
            self._bytes -= len(oldest)
            self.dropped += 1

    def pass_on(self, message: bytes, send: Callable[[bytes], int]) -> None:
        """Append a message and write the bytes that `send` takes without blocking.

        Raises:
            OSError: as `write`.
        """
        self.push(message)
        self.write(send)

    def write(self, send: Callable[[bytes], int]) -> None:
        """Write the bytes that `send` takes without blocking. `send` returns the number of bytes taken.

        Raises:
            OSError: any error of `send` except that it would block.
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
