"""Stories told in real time are worth something only while the machine runs: one that stood still is told again."""

import subprocess
import sys
import time
from collections.abc import Callable
from inspect import signature
from types import TracebackType
from typing import Any, Self, TypeVar

import pytest

STOOD_STILL_S = 0.040
"""A process that only wakes up is never so late by the work of a session, nor by four busy loops beside it."""
ATTEMPTS = 4
CALM_S, LONGEST_WAIT_S = 3.0, 60.0
"""A new attempt waits until the machine has run for so long as it should, but not for ever."""
_WATCH = """
import select, sys, time
longest_s, then_s, over = 0.0, time.monotonic(), False
print("watching", flush=True)
while not over:
    over = bool(select.select([sys.stdin], [], [], 0.002)[0])
    now_s = time.monotonic()
    longest_s, then_s = max(longest_s, now_s - then_s), now_s
print(longest_s)
"""

Found = TypeVar("Found")


class Witness:
    """A process that does nothing but wake up, and knows how late it was at worst.

    Attributes:
        limit_s: what is longer disturbs.
        process: it.
        longest_s: longest time between two awakenings; known when the watch is over.
    """

    process: subprocess.Popen[str]
    longest_s: float

    def __init__(self, limit_s: float = STOOD_STILL_S) -> None:
        self.limit_s = limit_s

    def __enter__(self) -> Self:
        self.process = subprocess.Popen(
            [sys.executable, "-c", _WATCH], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.process.stdout.readline()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        said, _ = self.process.communicate()
        self.longest_s = float(said)

    @property
    def disturbed(self) -> bool:
        """Whether the machine stood still."""
        return self.longest_s > self.limit_s


def wait_for_calm() -> None:
    """Wait until the machine runs as it should; what disturbs it comes in gusts."""
    end_s = time.monotonic() + LONGEST_WAIT_S
    while time.monotonic() < end_s:
        with Witness() as witness:
            time.sleep(CALM_S)
        if not witness.disturbed:
            return


def undisturbed(
    tell: Callable[[], Found],
    fine: Callable[[Found], bool] = lambda found: False,
    limit_s: float = STOOD_STILL_S,
) -> Found:
    """Tell a story of real processes, anew if the machine stood still meanwhile; the last attempt counts.

    What a product does while its machine stands still is another test's matter. A story that was not disturbed is
    never told again, whatever came of it, so that nothing can pass by being tried often.

    Args:
        tell: tells the story, each time in a folder of its own.
        fine: whether a story is good in spite of a disturbance, where that can be said at once.
        limit_s: standing still for longer disturbs.
    """
    for _ in range(ATTEMPTS - 1):
        witness = Witness(limit_s)
        try:
            with witness:
                found = tell()
        except Exception:  # the story came to its end as a test that fails does: by whatever exception
            if not witness.disturbed:
                raise
        else:
            if not witness.disturbed or fine(found):
                return found
        print(f"told again: the machine stood still for {witness.longest_s * 1e3:.0f} ms", file=sys.stderr)
        wait_for_calm()
    return tell()


def passes_its_tests(request: pytest.FixtureRequest) -> Callable[[object], bool]:
    """For a fixture that tells a story: whether all tests of its module that judge nothing but this story pass."""
    tests = [test for name, test in vars(request.module).items() if name.startswith("test_")]

    def fine(found: object) -> bool:
        return all(_passes(test, {request.fixturename: found, **case}) for test in tests for case in _cases(test))

    return fine


def _cases(test: Callable[..., None]) -> list[dict[str, Any]]:
    """The arguments of each time that a test is run, by its mark; none of these tests has two."""
    for mark in getattr(test, "pytestmark", ()):
        if mark.name == "parametrize":
            names, values = mark.args
            if isinstance(names, str):
                return [{names: value} for value in values]
            return [dict(zip(names, value, strict=True)) for value in values]
    return [{}]


def _passes(test: Callable[..., None], arguments: dict[str, Any]) -> bool:
    """Whether a test passes; one that needs more than these arguments, or nothing of them, judges something else."""
    if signature(test).parameters.keys() != arguments.keys():
        return True
    try:
        test(**arguments)
    except Exception:  # a test fails by whatever exception
        return False
    return True
