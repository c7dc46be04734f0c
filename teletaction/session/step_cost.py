"""Measures the computing time of a function on a shared machine by the quickest of several rounds."""

import time
from collections.abc import Callable

import numpy as np


def quickest_s(work: Callable[[], object], times: int, rounds: int = 7) -> float:
    """Return the mean time of one call in the quickest of several rounds of `times` calls, s."""
    best = np.inf
    for _ in range(rounds):
        begin_s = time.perf_counter()
        for _ in range(times):
            work()
        best = min(best, (time.perf_counter() - begin_s) / times)
    return float(best)
