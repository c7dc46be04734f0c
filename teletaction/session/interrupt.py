"""A polite end: asked for by a signal, or by a terminal that is closed, work ends as it does by Ctrl-C."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def ended_as_by_hand() -> Iterator[None]:
    """Within it, SIGTERM and SIGHUP raise KeyboardInterrupt; afterwards they do what they did."""
    before = {number: signal.signal(number, signal.default_int_handler) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
