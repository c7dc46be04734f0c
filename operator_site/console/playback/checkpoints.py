"""A recording read ahead by a process of its own: what jumps start from is made while the page plays."""

import multiprocessing
import signal
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from pathlib import Path

from operator_site.console.model import Console
from operator_site.console.playback.playback import Playback, Recording


class Checkpoints:
    """Makes the checkpoints of a recording, from its beginning on: some ten seconds of it in each second."""

    def __init__(self, path: Path, opened: ExitStack):
        """Start the process; it ends with `opened`."""
        context = multiprocessing.get_context("spawn")
        self._made, given = context.Pipe(duplex=False)
        process = context.Process(target=_read, args=(path, given), name="reading ahead", daemon=True)
        process.start()
        given.close()
        opened.callback(process.join)
        opened.callback(process.terminate)
        opened.callback(self._made.close)

    def made(self) -> Iterator[bytes]:
        """Checkpoints since the last call."""
        with suppress(EOFError):  # all are made
            while not self._made.closed and self._made.poll():
                yield self._made.recv_bytes()


def _read(path: Path, given: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal; the page's process ends this one
    playback = Playback(Recording(path), lambda: Console(live=False))
    with suppress(OSError):  # nobody wants them any more
        while playback.prepare():
            given.send_bytes(playback.checkpoints[-1])
