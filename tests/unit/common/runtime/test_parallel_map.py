"""Results and exceptions come in the order of the items from any number of processes."""

import os
from itertools import islice

import pytest

from common.runtime.parallel_map import FEWEST, in_order, kept_processes, processors

ITEMS = list(range(2 * FEWEST))


def squared(number: int) -> tuple[int, int]:
    return number * number, os.getpid()


def inverse(number: int) -> float:
    if number == 11:
        raise ValueError("no inverse of 11")
    return 1.0 / (number + 1)


def ended(number: int) -> int:
    os._exit(3)


@pytest.mark.parametrize("processes", [1, 2])
def test_results_are_in_order_and_progress_reaches_the_end(processes: int) -> None:
    shares: list[float] = []
    found = list(in_order(squared, ITEMS, processes, shares.append))
    assert [square for square, _ in found] == [number * number for number in ITEMS]
    assert (os.getpid() in {process for _, process in found}) == (processes == 1)
    assert shares == sorted(shares)
    assert (len(shares), shares[-1]) == (len(ITEMS), 1.0)
    few = in_order(squared, ITEMS[: FEWEST - 1], processes)
    assert {process for _, process in few} == {os.getpid()}, "not worth another process"


@pytest.mark.parametrize("processes", [1, 2])
def test_an_exception_of_an_item_follows_the_results_before_it(processes: int) -> None:
    results = in_order(inverse, ITEMS, processes)
    assert list(islice(results, 11)) == [1.0 / (number + 1) for number in range(11)]
    with pytest.raises(ValueError, match="no inverse of 11"):
        next(results)


def test_an_ended_process_is_reported() -> None:
    with pytest.raises(ChildProcessError, match="fewer with --processes"):
        list(in_order(ended, ITEMS, 2))
    with pytest.raises(ChildProcessError, match="fewer with --processes"), kept_processes(2) as mapped:
        list(mapped(ended, ITEMS))
    with pytest.raises(ValueError, match="at least 1"):
        list(in_order(squared, ITEMS, 0))
    assert processors() >= 1
