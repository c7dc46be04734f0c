"""A polite end: what is asked for by SIGTERM ends as it does by Ctrl-C, through every `finally`."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupted_by_sigterm() -> Iterator[None]:
    """Within it, SIGTERM raises KeyboardInterrupt; afterwards it does what it did."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
