"""Checks that a file or folder can be written before minutes of work for it."""

import errno
import os
import tempfile
from pathlib import Path

import typer


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


def out_folder(out: Path | None) -> Path | None:
    """Return the folder of an option; raise BadParameter where a file has its place."""
    for part in () if out is None else (out, *out.parents):
        if part.exists() and not part.is_dir():
            raise typer.BadParameter(f"{part} is a file. Name a folder that exists or can be created.")
    return out
