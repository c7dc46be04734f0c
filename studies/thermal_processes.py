"""Work of the study on several processors: jobs that share nothing, each on one thread of one process."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context
from typing import Any

Job = tuple[Callable[..., Any], tuple[Any, ...]]
Tell = Callable[[float], object]
Run = Callable[[Sequence[Job], Tell], list[Any]]
"""Results of jobs in their order; tells the share done, 0..1."""


@contextmanager
def processes(count: int) -> Iterator[Run]:
    """Run jobs in `count` processes; with 1 in this one."""
    if count == 1:
        with use_one_thread():
            yield _run_here
        return
    with ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=use_one_thread) as pool:

        def run(jobs: Sequence[Job], tell: Tell) -> list[Any]:
            futures = [pool.submit(work, *arguments) for work, arguments in jobs]
            for done, _ in enumerate(as_completed(futures), start=1):
                tell(done / len(futures))
            return [future.result() for future in futures]

        try:
            yield run
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def use_one_thread() -> Any:
    """Keep linear algebra to one thread: processors are shared out by process, and cost is compared by thread.

    Returns what restores it, as a context.
    """
    return import_module("threadpoolctl").threadpool_limits(1)


def _run_here(jobs: Sequence[Job], tell: Tell) -> list[Any]:
    results = []
    for done, (work, arguments) in enumerate(jobs, start=1):
        results.append(work(*arguments))
        tell(done / len(jobs))
    return results
