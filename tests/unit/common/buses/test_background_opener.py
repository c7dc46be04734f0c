"""A device is opened beside the loop, with growing pauses between tries, and handed over once."""

import threading
import time

import pytest

from common.buses.background_opener import STEADY_S, BackgroundOpener
from tests.waiting import wait_until


def test_a_device_is_handed_over_once_and_opened_again_on_request() -> None:
    opened: list[int] = []

    def opener() -> int:
        opened.append(len(opened) + 1)
        return opened[-1]

    background = BackgroundOpener(opener)
    assert background.take() is None
    for expected in (1, 2):
        background.start()
        background.start()  # one try under way is enough
        wait_until(lambda expected=expected: background.take() == expected)
        assert background.take() is None
    assert opened == [1, 2]


@pytest.mark.parametrize("error", [OSError("no such port"), ValueError("another device"), KeyError("a library's bug")])
def test_any_error_of_a_library_is_reported_and_the_opening_repeated(error: Exception) -> None:
    there = threading.Event()

    def opener() -> str:
        if not there.is_set():
            raise error
        return "open"

    background = BackgroundOpener(opener, retry_s=0.001)
    background.start()
    wait_until(lambda: background.problem is error)
    there.set()
    wait_until(lambda: background.take() == "open")
    assert background.problem is None


@pytest.mark.parametrize("stopped_first", [True, False])
def test_a_device_that_is_no_longer_wanted_is_closed(stopped_first: bool) -> None:
    go, closed, before = threading.Event(), [], set(threading.enumerate())

    def opener() -> str:
        go.wait(5.0)
        return "open"

    background = BackgroundOpener(opener, discard=closed.append)
    background.start()
    if stopped_first:
        background.stop()
    go.set()
    if not stopped_first:
        wait_until(lambda: before >= set(threading.enumerate()), "it has opened, and nobody has taken it")
        background.stop()
    wait_until(lambda: closed)
    assert closed == ["open"]
    assert background.take() is None


def test_closing_never_waits_for_the_opener() -> None:
    go, ended, tries = threading.Event(), threading.Event(), []

    def opener() -> str:
        tries.append(1)
        go.wait(5.0)
        ended.set()
        raise OSError("gone")

    background = BackgroundOpener(opener, retry_s=0.001)
    start = time.monotonic()
    background.start()
    assert background.take() is None
    background.stop()
    assert time.monotonic() - start < 1.0
    go.set()
    assert ended.wait(5.0)
    wait_until(lambda: background.problem is not None)
    assert background.take() is None
    assert len(tries) == 1


def test_a_device_lost_at_once_is_opened_again_after_growing_pauses() -> None:
    now_s, waited_s = 100.0, list[float]()

    class Stop(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            waited_s.append(timeout or 0.0)
            return False

    background = BackgroundOpener(lambda: "open", retry_s=0.25, now_s=lambda: now_s)
    background._stop = Stop()

    def reopened() -> float:
        waited_s.clear()
        background.start()
        wait_until(lambda: background.take() == "open")
        return sum(waited_s)

    assert [reopened() for _ in range(6)] == [0.0, 0.25, 0.5, 1.0, 2.0, 2.0]
    now_s += STEADY_S
    assert [reopened(), reopened()] == [0.0, 0.25], "one that lasted is opened again at once"
