"""Keeps a person's latched stop in a file, so that a restart of the remote site does not clear it.

The file exists while the stop is latched, and holds its code. Any other content is a stop, too, such as none after a
full disk or a power cut. A thread writes the file, because a slow disk must not delay a tick.
"""

import logging
import os
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Self

from common.faults.fault import PERSONS_STOPS, Fault, FaultCode
from common.files.printable import printable
from common.files.whole_file import read_whole

log = logging.getLogger(__name__)

SUFFIX = ".stop"
"""The file has the name of the site's status file, with this suffix."""
_LONGEST = 64
AGAIN_S = 1.0
"""Time after which a change that could not be written is tried again, s."""
_PATIENCE_S = 2.0
"""Maximum wait for the disk at the end of the process, s."""
_END = "end"
_OPEN = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC


class StopFile:
    """The file of one remote site.

    Attributes:
        problem: what a restart would do to a latched stop; empty where the stop survives.
    """

    def __init__(self, status: Path | None):
        """Keep stops beside this status file; without one, keep none."""
        self._path = None if status is None else status.with_suffix(SUFFIX)
        self._place = printable(str(self._path))
        self.problem = ""
        self._latched: str | None = None
        self._changes: SimpleQueue[str | None] = SimpleQueue()
        self._writer = Thread(target=self._write_changes, name="stop file", daemon=True)
        self._writer.start()
        if self._path is None:
            self._report("clear a latched stop: no status file is configured")
        elif not os.access(self._path.parent, os.W_OK | os.X_OK):
            self._report(f"clear a latched stop: {self._place} cannot be written")

    def latched(self) -> Fault | None:
        """Return the stop that an earlier process of this site has latched; None without one."""
        if self._path is None:
            return None
        try:
            content = read_whole(self._path, _LONGEST)[0].strip().decode("ascii", errors="replace")
        except FileNotFoundError:
            return None
        except OSError as error:
            content = str(error.strerror)
        log.warning("a stop was latched before this start (%s): %s", self._place, printable(content) or "damaged")
        found = next((code for code in PERSONS_STOPS if code == content), FaultCode.UNKNOWN)
        self._latched = found
        return Fault(found, detail=f"in {self._place}" if found is FaultCode.UNKNOWN else "")

    def keep(self, stop: FaultCode | None) -> None:
        """Write the stop that is latched now, or remove the file for None; returns at once."""
        if stop != self._latched:
            self._latched = stop
            self._changes.put(stop)

    def _write_changes(self) -> None:
        stop = self._changes.get()
        while stop != _END:
            written = self._path is None or self._is_written(self._path, stop)
            with suppress(Empty):  # the same again
                stop = self._changes.get(timeout=None if written else AGAIN_S)

    def _is_written(self, path: Path, stop: str | None) -> bool:
        try:
            _write(path, stop)
        except OSError as error:
            if stop is None:
                outcome = "latch the cleared stop again"
            elif path.exists():
                outcome = "keep the latched stop without its cause"
            else:
                outcome = "clear a latched stop"
            self._report(f"{outcome}: {self._place}: {error.strerror}")
            return False
        self.problem = ""
        return True

    def _report(self, outcome: str) -> None:
        problem = f"a restart of this site would {outcome}"
        if problem != self.problem:
            log.warning("%s", problem)
        self.problem = problem

    def close(self) -> None:
        """Wait for the last change."""
        self._changes.put(_END)
        self._writer.join(timeout=_PATIENCE_S)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _write(path: Path, stop: str | None) -> None:
    """Write or remove the file, and wait for the disk."""
    if stop is None:
        path.unlink(missing_ok=True)
    else:
        file = os.open(path, _OPEN, 0o600)
        try:
            os.write(file, f"{stop}\n".encode())
            os.fsync(file)
        finally:
            os.close(file)
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    with suppress(OSError):  # a file system that cannot do this for folders
        os.fsync(folder)
    os.close(folder)
