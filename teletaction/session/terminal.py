"""Prints lines and progress to stderr. A terminal that was closed takes none, and raises no error."""

import errno
import sys

_CLEAR = "\r\x1b[K"


def say(text: str) -> None:
    """Print a line, in place of the progress shown."""
    _print(f"{_CLEAR if sys.stderr.isatty() else ''}{text}\n")


def show(text: str) -> None:
    """Show progress on the terminal's last line, in place of the earlier one; show nothing elsewhere."""
    if sys.stderr.isatty():
        _print(f"{_CLEAR}{text}")


def _print(text: str) -> None:
    try:
        print(text, end="", file=sys.stderr, flush=True)
    except OSError as error:
        if error.errno != errno.EIO:  # as of a full disk
            raise
