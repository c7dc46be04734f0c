"""Feed of a site in a test bed: it passes the site's data to a console without a socket."""

from collections import deque
from collections.abc import Iterator

from operator_site.session.console_feed import BATCH_S, STREAMS, Fed

_WAITING = 8
"""Largest number of batches that wait for a console; older ones are dropped."""


class MemoryFeed:
    """Both ends of a feed: the site writes, one console receives."""

    def __init__(self) -> None:
        """Start without data."""
        self._batch: list[Fed] = []
        self._sent: deque[list[Fed]] = deque(maxlen=_WAITING)
        self._sent_ns = 0

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """As `operator_site.session.console_feed.ConsoleFeed.write`."""
        if stream in STREAMS:
            self._batch.append(Fed(stream, time_ns, payload))

    def step(self, now_ns: int) -> None:
        """As `operator_site.session.console_feed.ConsoleFeed.step`."""
        if self._batch and not 0 <= now_ns - self._sent_ns < BATCH_S * 1e9:
            self._sent_ns = now_ns
            self._sent.append(self._batch)
            self._batch = []

    def receive(self) -> Iterator[Fed]:
        """As `operator_site.session.console_feed.FeedSource.receive`."""
        while self._sent:
            yield from self._sent.popleft()
