"""Starts the command line. Ctrl-C ends it without a traceback while it imports the commands."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit code; see `teletaction.command_line`."""
    with _interrupt_ends_at_once():
        from teletaction.command_line import run  # noqa: PLC0415
    return run(arguments)


@contextmanager
def _interrupt_ends_at_once() -> Iterator[None]:
    """Let SIGINT end the process silently, as a shell expects it, instead of raising KeyboardInterrupt in an import."""
    raises = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not in a background job of a script
    if not raises or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
