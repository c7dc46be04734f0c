"""Keeps a short text in a file of its own, so that a restart of the remote site finds it.

The file exists while there is a text, and is overwritten in place: a full disk or a power cut leaves a damaged file,
never none. A thread writes it, because a slow disk must not delay a tick.
"""

import logging
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Self

from common.files.printable import printable
from common.files.whole_file import read_whole

log = logging.getLogger(__name__)

_LONGEST = 64
AGAIN_S = 1.0
"""Time after which a change that could not be written is tried again, s."""
_PATIENCE_S = 2.0
"""Maximum wait for the disk at the end of the process, s."""
_END = "end"
_OPEN = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC


class KeptText:
    """One file.

    Attributes:
        place: its path, printable.
        problem: what a restart would do with the present text; empty where it finds it.
    """

    def __init__(self, path: Path | None, name: str, would: Callable[[str | None, bool], str]):
        """Keep texts in this file; without one, keep none.

        Args:
            path: the file.
            name: name of the thread.
            would: what a restart would do, for the text that could not be written, and whether there is a file.
        """
        self._path, self._would = path, would
        self.place = printable(str(path))
        self.problem = ""
        self._text: str | None = None
        self._changes: SimpleQueue[str | None] = SimpleQueue()
        self._writer = Thread(target=self._write_changes, name=name, daemon=True)
        self._writer.start()
        if path is None:
            self._report(f"{would('', False)}: no status file is configured")
        elif not os.access(path.parent, os.W_OK | os.X_OK):
            self._report(f"{would('', False)}: {self.place} cannot be written")

    def read(self) -> str | None:
        """Return the text of an earlier process, or why it cannot be read; None without a file."""
        if self._path is None:
            return None
        try:
            return read_whole(self._path, _LONGEST)[0].strip().decode("ascii", errors="replace")
        except FileNotFoundError:
            return None
        except OSError as error:
            return str(error.strerror)

    def found(self, text: str) -> None:
        """Note the text that counts as the file's, so that it is written only once it changes."""
        self._text = text

    def keep(self, text: str | None) -> None:
        """Write the present text, or remove the file for None; returns at once."""
        if text != self._text:
            self._text = text
            self._changes.put(text)

    def _write_changes(self) -> None:
        text = self._changes.get()
        while text != _END:
            written = self._path is None or self._is_written(self._path, text)
            with suppress(Empty):  # the same again
                text = self._changes.get(timeout=None if written else AGAIN_S)

    def _is_written(self, path: Path, text: str | None) -> bool:
        try:
            _write(path, text)
        except OSError as error:
            self._report(f"{self._would(text, path.exists())}: {self.place}: {error.strerror}")
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


def _write(path: Path, text: str | None) -> None:
    """Write or remove the file, and wait for the disk."""
    if text is None:
        path.unlink(missing_ok=True)
    else:
        file = os.open(path, _OPEN, 0o600)
        try:
            os.write(file, f"{text}\n".encode())
            os.fsync(file)
        finally:
            os.close(file)
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    with suppress(OSError):  # a file system that cannot do this for folders
        os.fsync(folder)
    os.close(folder)
