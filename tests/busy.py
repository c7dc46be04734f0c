"""Other programs that take the processors."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from teletaction.session.processes import die_with_parent


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Run `count` processes that never rest, each in a session of its own."""
    loops = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"], preexec_fn=die_with_parent)  # noqa: PLW1509
        for _ in range(count)
    ]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
