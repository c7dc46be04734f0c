"""What an earlier run left is never written over: it is given a name of its own, or the new one takes the next."""

from pathlib import Path


def free_name(path: Path) -> Path:
    """`path`, or where that exists already, the first of its successors -1, -2 ... that does not."""
    number, found = 0, path
    while found.exists():
        number += 1
        found = path.with_stem(f"{path.stem}-{number}")
    return found


def set_aside(path: Path) -> None:
    """Give the file at `path` the name of its first free successor; nothing, where there is none, or a link.

    Raises:
        OSError: it cannot be renamed.
    """
    if path.is_file() and not path.is_symlink():
        path.rename(free_name(path))
