"""Creates files that only their owner reads and writes, never through a symbolic link."""

import errno
import os
import re
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from common.files.no_room import NO_ROOM

PART = re.compile(r"(\.[0-9a-f]{8})?\.part$")
"""End of the name of a file that is being made, or that a killed process has left."""
_LEFT_AFTER_S = 3600.0
"""Time without a change after which no process writes an unfinished file any more, s."""
_FLAGS = os.O_WRONLY | os.O_NOFOLLOW | os.O_CLOEXEC


def refuse_link(path: Path) -> None:
    """Raise OSError where `path` is a symbolic link, because the file would be written elsewhere."""
    if path.is_symlink():
        raise OSError(errno.ELOOP, "is a symbolic link, refused", str(path))


def create_private(path: Path, *, replace: bool = False) -> IO[bytes]:
    """Create a file with mode 0600 and open it for writing; a device at `path` is opened as it is.

    Args:
        path: its folder must exist.
        replace: remove a file of that name first; otherwise an existing file is an error.

    Raises:
        FileExistsError: the file exists.
        OSError: `path` is a symbolic link, or cannot be created.
    """
    refuse_link(path)
    if replace and path.is_file():
        path.unlink()
    try:
        number = os.open(path, _FLAGS | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path)) from None
        if not path.is_char_device():
            raise
        number = os.open(path, _FLAGS)
    return os.fdopen(number, "wb")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give the path of a file to make; once it is whole, it replaces the one at `path`. A failure leaves that one.

    Each call gives another path, as two commands may write the same file. A device at `path` is given as it is. What a
    killed process has left of this file is removed in the end.

    Raises:
        OSError: `path` is a symbolic link, cannot be replaced, or has no room.
    """
    refuse_link(path)
    made = path if path.is_char_device() else path.with_name(f"{path.name}.{secrets.token_hex(4)}.part")
    try:
        yield made
        if made != path:
            made.replace(path)
            _remove_left(path)
    except BaseException as error:
        discard(made)
        if isinstance(error, OSError) and _is_of(error, made):
            raise OSError(error.errno, error.strerror, str(path)) from None
        raise


@contextmanager
def creating(path: Path) -> Iterator[Path]:
    """Give the path of a file to make, as `replacing` does; an existing file is an error.

    Raises:
        FileExistsError: the file exists.
        OSError: as `replacing`.
    """
    _refuse_existing(path)
    with replacing(path) as made:
        yield made
        _refuse_existing(path)


def _remove_left(path: Path) -> None:
    """Remove unfinished files of `path`, just written, that have not changed for an hour."""
    with suppress(OSError), os.scandir(path.parent) as entries:
        latest_s = path.stat().st_mtime - _LEFT_AFTER_S
        for entry in entries:
            if (end := entry.name.removeprefix(path.name)) != entry.name and PART.fullmatch(end):
                status = entry.stat(follow_symlinks=False)
                if stat.S_ISREG(status.st_mode) and status.st_mtime < latest_s:
                    os.unlink(entry.path)


def _refuse_existing(path: Path) -> None:
    refuse_link(path)
    if path.exists() and not path.is_char_device():
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))


def _is_of(error: OSError, made: Path) -> bool:
    """Return whether an error names a file in the making, or is that of a write, which names none."""
    if error.filename is None:
        return error.errno in (*NO_ROOM, errno.EFBIG)
    return str(error.filename) == str(made)


def write_private(path: Path, content: bytes) -> None:
    """Write a small file with mode 0600; it replaces an earlier one, which stays where the new one does not fit.

    Raises:
        OSError: `path` is a symbolic link, or cannot be written.
    """
    try:
        with replacing(path) as made, create_private(made, replace=True) as file:
            file.write(content)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None


def discard(path: Path) -> None:
    """Remove an unfinished file that `create_private` has created; a device at `path` stays."""
    if not path.is_char_device():
        path.unlink(missing_ok=True)
