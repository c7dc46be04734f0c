"""Finds unused file names, so that a run does not overwrite files of an earlier run."""

from pathlib import Path


def free_name(path: Path) -> Path:
    """Return `path`, or where it exists, the first of its successors -1, -2, ... that does not."""
    number, found = 0, path
    while found.exists():
        number += 1
        found = path.with_stem(f"{path.stem}-{number}")
    return found


def set_aside(path: Path) -> None:
    """Rename the file at `path` to its first free successor; does nothing where there is none, or a link.

    Raises:
        OSError: the file cannot be renamed.
    """
    if path.is_file() and not path.is_symlink():
        path.rename(free_name(path))
