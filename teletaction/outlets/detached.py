"""Runs a tool's server in a thread of its own: one that hangs delays neither the feed nor the end of the process."""

import logging
import queue
import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol, Self

from common.runtime.containment import Containment
from teletaction.export.named_recording import NamedMessage

log = logging.getLogger(__name__)

WAITING = 150
"""Maximum number of batches that wait for a server, about five seconds of the feed; further ones are dropped."""
END_S = 3.0
"""Time in which a server may end, s."""


class Outlet(Protocol):
    """A tool's server.

    Attributes:
        address: where clients find it.
    """

    address: str

    def offer(self, messages: Sequence[NamedMessage]) -> None:
        """Send messages, oldest first, to the clients that are connected."""

    def close(self) -> None:
        """End all connections and release the port."""


class Detached:
    """Passes messages to a server and never waits for it.

    Attributes:
        dropped: number of messages that were dropped because the server was behind.
    """

    def __init__(self, outlet: Outlet):
        """Start the thread; on exit from this context the server is closed."""
        self.dropped = 0
        self._outlet = outlet
        self._hung = False
        """Whether the server took nothing within END_S at the end; then the thread ends after the present batch."""
        self._batches: queue.Queue[Sequence[NamedMessage] | None] = queue.Queue(WAITING)
        self._contained = Containment()
        self._thread = threading.Thread(target=self._run, name="outlet", daemon=True)
        self._thread.start()

    def offer(self, messages: Sequence[NamedMessage]) -> None:
        """Pass messages on, or drop and count them."""
        try:
            self._batches.put_nowait(messages)
        except queue.Full:
            self.dropped += len(messages)

    def _run(self) -> None:
        while not self._hung and (messages := self._batches.get()) is not None:
            with self._contained.step("offer", latches=False):
                self._outlet.offer(messages)
        with self._contained.step("close", latches=False):
            self._outlet.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._batches.put(None, timeout=END_S)
        except queue.Full:
            self._hung = True
            with suppress(queue.Full):
                self._batches.put_nowait(None)
        self._thread.join(END_S)
        if self._thread.is_alive():
            log.warning("the server at %s did not end", self._outlet.address)
