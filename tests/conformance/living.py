"""Emulated devices that live in a thread of their own, at real addresses."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sim_sensors.select_loop import SelectLoop

STEP_S = 0.002


@contextmanager
def alive(loop: SelectLoop, step: Callable[[float], None]) -> Iterator[None]:
    """Lets a device live while the test talks to it."""
    ended = threading.Event()

    def live() -> None:
        while not ended.is_set():
            loop.serve(STEP_S)
            step(loop.now())

    thread = threading.Thread(target=live)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
