"""Reads a small file whole through one descriptor, so that the checked file is the one that is read."""

import errno
import os
import stat
from pathlib import Path

MOST_BYTES = 1 << 20
"""Maximum size of a configuration, list or key file, bytes."""


def read_whole(path: Path, most_bytes: int = MOST_BYTES) -> tuple[bytes, os.stat_result]:
    """Return content and status of a regular file; `path` may be a link to one. Never waits.

    Raises:
        FileNotFoundError: the file does not exist.
        OSError: the file cannot be read, is not a regular file, or is larger than `most_bytes`; `strerror` names the
            reason.
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
