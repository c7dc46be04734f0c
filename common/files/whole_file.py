"""Reads a small file whole, through one descriptor: what was checked is what is read."""

import errno
import os
import stat
from pathlib import Path

MOST_BYTES = 1 << 20
"""Size of the largest configuration, list or key file that is read, bytes."""


def read_whole(path: Path, most_bytes: int = MOST_BYTES) -> tuple[bytes, os.stat_result]:
    """Content and status of a regular file, which `path` may be a link to. Never waits.

    Raises:
        FileNotFoundError: there is none.
        OSError: it cannot be read, is no regular file, or is larger than `most_bytes`; `strerror` says which.
    """
    try:
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except ValueError:
        raise OSError(errno.EINVAL, "a zero byte or a lone surrogate in its name", str(path)) from None
    with open(number, "rb") as file:
        status = os.fstat(number)
        if stat.S_ISDIR(status.st_mode):
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "is no regular file", str(path))
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise OSError(errno.EFBIG, f"is larger than {most_bytes} bytes", str(path))
    return content, status
