import threading
import time
from collections.abc import Callable

import pytest

from common.background import BackgroundOpener


def until(done: Callable[[], object], seconds: float = 5.0) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if done():
            return True
        threading.Event().wait(0.001)
    return False


def test_it_hands_over_once_and_opens_again_when_asked() -> None:
    opened: list[int] = []

    def opener() -> int:
        opened.append(len(opened) + 1)
        return opened[-1]

    background = BackgroundOpener(opener)
    assert background.take() is None
    for expected in (1, 2):
        background.start()
        background.start()  # one try under way is enough
        taken: list[int] = []
        assert until(lambda: taken.extend(t for t in [background.take()] if t is not None) or taken)  # noqa: B023
        assert taken == [expected]
        assert background.take() is None
    assert opened == [1, 2]


@pytest.mark.parametrize("error", [OSError("no such port"), ValueError("another device")])
def test_it_tries_again_and_says_why_it_failed(error: Exception) -> None:
    there = threading.Event()

    def opener() -> str:
        if not there.is_set():
            raise error
        return "open"

    background = BackgroundOpener(opener, retry_s=0.001)
    background.start()
    assert until(lambda: background.problem is error)
    there.set()
    assert until(lambda: background.take() == "open")
    assert background.problem is None


def test_it_goes_on_whatever_a_library_raises() -> None:
    raised = [RuntimeError("a bug"), KeyError("another")]

    def opener() -> str:
        if raised:
            raise raised.pop()
        return "open"

    background = BackgroundOpener(opener, retry_s=0.001)
    background.start()
    assert until(lambda: background.take() == "open")


@pytest.mark.parametrize("stopped_first", [True, False])
def test_what_is_opened_and_not_wanted_any_more_is_closed(stopped_first: bool) -> None:
    go, closed = threading.Event(), []

    def opener() -> str:
        go.wait(5.0)
        return "open"

    background = BackgroundOpener(opener)
    background.discard = closed.append
    background.start()
    if stopped_first:
        background.stop()
        go.set()
    else:
        go.set()
        assert until(lambda: background._opened)
        background.stop()
    assert until(lambda: closed)
    assert closed == ["open"]
    assert background.take() is None


def test_it_never_waits_for_the_opener_and_gives_up_when_told() -> None:
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
    assert until(lambda: background.problem is not None)
    assert background.take() is None
    assert len(tries) == 1
