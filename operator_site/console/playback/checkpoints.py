"""Reads a recording ahead in a process of its own, to make the checkpoints that jumps start from."""

import multiprocessing
import signal
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from operator_site.console.model import Console
from operator_site.console.playback.playback import Playback, Recording


class Checkpoints:
    """Makes the checkpoints of a recording from its beginning, at about ten times its speed."""

    def __init__(self, path: Path, opened: ExitStack):
        """Start the process; closing `opened` ends it."""
        context = multiprocessing.get_context("spawn")
        self._made, given = context.Pipe(duplex=False)
        process = context.Process(target=_read, args=(path, given), name="reading ahead", daemon=True)
        process.start()
        given.close()
        opened.callback(process.join)
        opened.callback(process.terminate)
        opened.callback(self._made.close)

    def made(self) -> Iterator[bytes]:
        """Yield the checkpoints made since the last call."""
        with suppress(EOFError):  # the process has made all checkpoints
            while not self._made.closed and self._made.poll():
                yield self._made.recv_bytes()


def _read(path: Path, given: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the page's process takes it and ends this one
    playback = Playback(Recording(path), lambda: Console(live=False))
    with suppress(OSError):  # the page's process has closed the pipe
        while playback.prepare():
            given.send_bytes(playback.checkpoints[-1])
