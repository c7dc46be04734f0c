"""Checks that a file can be written before minutes of work for it."""

import errno
import os
import tempfile
from pathlib import Path


def require_place(out: Path) -> None:
    """Raise OSError for a file that cannot be written; a device can."""
    file = Path(os.path.realpath(out))
    if file.is_dir():
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR), str(out))
    if file.exists() and not file.is_file():  # a device
        return
    try:
        tempfile.TemporaryFile(dir=file.parent).close()
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(out)) from None
