"""Applies a function to many items on all processors; results keep the order of the items."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

Map = Callable[[Callable[..., Any], Iterable[Any]], Iterable[Any]]
"""The built-in `map` with one iterable."""
Progress = Callable[[float], object]
"""Function that receives the completed share, 0..1."""

_ENDED = "a process was ended from outside: try fewer with --processes"
FEWEST = 8
"""Minimum number of items for which further processes are worth their start of about a second."""


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0))


def unseen(share: float) -> None:
    """Ignore the progress."""


def in_order(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    processes: int,
    progress: Progress = unseen,
    fewest: int = FEWEST,
) -> Iterator[Result]:
    """Yield `work(item)` for each item, in their order; results do not depend on `processes`.

    Args:
        work: a function of a module, or a `partial` of one, that can be pickled.
        items: items that can be pickled.
        processes: maximum number of processes; with 1, or fewer than `fewest` items, this process works alone.
        progress: function that receives the completed share after each item.
        fewest: minimum number of items for which further processes are worth their start.

    Raises:
        ValueError: `processes` is below 1.
        ChildProcessError: a process was ended from outside, such as by the system for lack of memory.
        Exception: the first exception of `work`, after the results before it.
    """
    if processes < 1:
        raise ValueError(f"--processes: at least 1, not {processes}")
    if processes == 1 or len(items) < fewest:
        yield from _counted(map(work, items), len(items), progress)
        return
    count = min(processes, len(items))
    # Processes are spawned, because one that is forked from a process with threads may hang.
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        results = pool.map(work, items)
        try:
            yield from _counted(results, len(items), progress)
        except BrokenProcessPool:
            raise ChildProcessError(_ENDED) from None
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def kept_processes(processes: int) -> Iterator[Map]:
    """Yield a `map` for work in many rounds: its processes stay until the end.

    Args:
        processes: number of processes; 1 uses this process alone.

    Raises:
        ChildProcessError: a process was ended from outside, such as by the system for lack of memory.
    """
    if processes == 1:
        yield map
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        try:
            yield pool.map
        except BrokenProcessPool:
            raise ChildProcessError(_ENDED) from None


def _counted(results: Iterable[Result], count: int, progress: Progress) -> Iterator[Result]:
    for number, result in enumerate(results, 1):
        progress(number / count)
        yield result
