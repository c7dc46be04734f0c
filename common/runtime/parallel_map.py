"""The same work on many items, on all processors, with results in the order of the items."""

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
"""As the built-in `map`, with one iterable."""
Progress = Callable[[float], object]
"""Is given the share done, 0..1."""

_ENDED = "a process was ended from outside: try fewer with --processes"
FEWEST = 8
"""Items for which further processes are worth their start, which takes about a second."""


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0))


def unseen(share: float) -> None:
    """Progress that nobody looks at."""


def in_order(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    processes: int,
    progress: Progress = unseen,
    fewest: int = FEWEST,
) -> Iterator[Result]:
    """Yield `work(item)` for each item, in their order; what they are does not depend on `processes`.

    Args:
        work: a function of a module, or a `partial` of one, that can be pickled.
        items: that can be pickled.
        processes: at most this number; 1, or fewer than `fewest` items: this process alone.
        progress: is given the share done after each item.
        fewest: items for which further processes are worth their start.

    Raises:
        ValueError: `processes` is below 1.
        ChildProcessError: a process was ended from outside, as by the system for want of memory.
        Exception: what `work` raises for the first item for which it does, after the results before it.
    """
    if processes < 1:
        raise ValueError(f"--processes: at least 1, not {processes}")
    if processes == 1 or len(items) < fewest:
        yield from _counted(map(work, items), len(items), progress)
        return
    count = min(processes, len(items))
    # Processes are spawned: one that is forked from a process with threads may hang.
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
    """A `map` for work that comes in many rounds: its processes stay until the end.

    Args:
        processes: 1: this process alone.

    Raises:
        ChildProcessError: a process was ended from outside, as by the system for want of memory.
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
