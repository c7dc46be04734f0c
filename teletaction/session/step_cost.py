"""What a piece of work costs on a machine that others use too: the quickest of some rounds."""

import time
from collections.abc import Callable

import numpy as np


def quickest_s(work: Callable[[], object], times: int, rounds: int = 7) -> float:
    """Time of one call, s.

    Args:
        work: what is timed.
        times: calls in a round.
        rounds: of which the quickest counts.
    """
    best = np.inf
    for _ in range(rounds):
        begin_s = time.perf_counter()
        for _ in range(times):
            work()
        best = min(best, (time.perf_counter() - begin_s) / times)
    return float(best)
