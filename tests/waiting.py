"""Waiting for what another thread or process does: the one helper of all tests that wait in real time."""

import time
from collections.abc import Callable

PATIENCE_S = 10.0


def wait_until(
    reached: Callable[[], object], what: object = "", patience_s: float = PATIENCE_S, every_s: float = 0.005
) -> None:
    """Return as soon as something is reached.

    Args:
        reached: asked again and again; may do a turn of what is waited for.
        what: for the message; called where it is a function.
        patience_s: longest wait, s.
        every_s: between two questions, s.

    Raises:
        AssertionError: it was not reached in time.
    """
    end_s = time.monotonic() + patience_s
    while not reached():
        assert time.monotonic() < end_s, what() if callable(what) else what
        time.sleep(every_s)
