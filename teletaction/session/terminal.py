"""Prints lines and progress to stderr."""

import sys

_CLEAR = "\r\x1b[K"


def say(text: str) -> None:
    """Print a line, in place of the progress shown."""
    print(f"{_CLEAR if sys.stderr.isatty() else ''}{text}", file=sys.stderr, flush=True)


def show(text: str) -> None:
    """Show progress on the terminal's last line, in place of the earlier one; show nothing elsewhere."""
    if sys.stderr.isatty():
        print(f"{_CLEAR}{text}", end="", file=sys.stderr, flush=True)
