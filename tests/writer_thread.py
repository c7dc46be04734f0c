"""A recording's writer as a thread of the test, where the test has to reach into it."""

import os
import socket
import threading
from typing import IO

import pytest

from common.recording import recorder
from common.recording.writer_process import write_recording


class WriterThread:
    """Stands where the process does."""

    def __init__(self, owner: socket.socket, file: IO[bytes]) -> None:
        self._owner, self._file = owner, file
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        with self._owner, self._file:
            write_recording(self._owner, self._file)

    def wait(self) -> None:
        """Until it has ended."""
        self._thread.join(30.0)
        assert not self._thread.is_alive()


def start_thread(file: IO[bytes]) -> tuple[socket.socket, WriterThread]:
    """As the function that starts the process."""
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    own = os.fdopen(os.dup(file.fileno()), "wb") if type(file).__module__ == "_io" else file
    return ours, WriterThread(theirs, own)


def write_in_a_thread(patch: pytest.MonkeyPatch) -> None:
    """From now on, recorders have a thread instead of a process."""
    patch.setattr(recorder, "_start_writer", start_thread)
