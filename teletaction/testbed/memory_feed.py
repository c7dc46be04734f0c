"""A site's feed in a test bed: what consoles see of the site, without a socket."""

from collections import deque
from collections.abc import Iterator

from operator_site.feed import BATCH_S, STREAMS, Fed

_WAITING = 8
"""Batches that wait for a console that does not read; older ones are lost to it."""


class MemoryFeed:
    """Both ends of a feed: the site writes, one console receives."""

    def __init__(self) -> None:
        """Nothing was written."""
        self._batch: list[Fed] = []
        self._sent: deque[list[Fed]] = deque(maxlen=_WAITING)
        self._sent_ns = 0

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """As `operator_site.feed.ConsoleFeed.write`."""
        if stream in STREAMS:
            self._batch.append(Fed(stream, time_ns, payload))

    def step(self, now_ns: int) -> None:
        """As `operator_site.feed.ConsoleFeed.step`."""
        if self._batch and not 0 <= now_ns - self._sent_ns < BATCH_S * 1e9:
            self._sent_ns = now_ns
            self._sent.append(self._batch)
            self._batch = []

    def receive(self) -> Iterator[Fed]:
        """As `operator_site.feed.FeedSource.receive`."""
        while self._sent:
            yield from self._sent.popleft()
