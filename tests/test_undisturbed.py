"""When a story is told again, and when never."""

import os
import signal
import time
from types import SimpleNamespace
from typing import Any

import pytest

from tests import undisturbed as module
from tests.undisturbed import (
    ATTEMPTS,
    CALM_S,
    LONGEST_WAIT_S,
    STOOD_STILL_S,
    Witness,
    passes_its_tests,
    undisturbed,
    wait_for_calm,
)

HELD_UP_S = 5 * STOOD_STILL_S


def hold_up(witness: Witness) -> None:
    witness.process.send_signal(signal.SIGSTOP)
    os.waitpid(witness.process.pid, os.WUNTRACED)  # it has stopped
    time.sleep(HELD_UP_S)
    witness.process.send_signal(signal.SIGCONT)


def test_the_witness_knows_how_long_it_was_held_up() -> None:
    with Witness() as witness:
        hold_up(witness)
    assert witness.disturbed
    assert witness.longest_s > 0.9 * HELD_UP_S


@pytest.fixture
def still_s(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """How long the machine will stand still during each attempt, s."""
    coming: list[float] = []

    class Foreseen(Witness):
        def __enter__(self) -> "Foreseen":
            self.longest_s = coming.pop(0)
            return self

        def __exit__(self, *_: object) -> None:
            pass

    monkeypatch.setattr(module, "Witness", Foreseen)
    monkeypatch.setattr(module, "wait_for_calm", lambda: None)
    return coming


class Story:
    """What comes of each attempt, in turn; an exception is raised."""

    def __init__(self, *ends: str | Exception) -> None:
        self.ends = list(ends)

    def __call__(self) -> str:
        end = self.ends.pop(0)
        if isinstance(end, Exception):
            raise end
        return end


def test_a_quiet_story_is_told_once_whatever_comes_of_it(still_s: list[float]) -> None:
    still_s[:] = [0.9 * STOOD_STILL_S] * 2
    assert undisturbed(Story("bad", "good")) == "bad"
    with pytest.raises(AssertionError, match="product"):
        undisturbed(Story(AssertionError("product"), "good"))


def test_a_disturbed_story_is_told_again_whether_it_ended_or_broke(still_s: list[float]) -> None:
    still_s[:] = [2.0 * STOOD_STILL_S, 0.0] * 2
    assert undisturbed(Story("bad", "good")) == "good"
    assert undisturbed(Story(AssertionError("machine"), "good")) == "good"


def test_a_disturbed_story_that_is_good_stays(still_s: list[float]) -> None:
    still_s[:] = [2.0 * STOOD_STILL_S]
    assert undisturbed(Story("good", "another"), fine=lambda found: found == "good") == "good"


def test_a_story_is_fine_when_all_that_its_module_asks_of_it_is_so() -> None:
    def test_it_is_long(story: str) -> None:
        assert len(story) > 2

    @pytest.mark.parametrize("word", ["a", "b"])
    def test_a_word_is_in_it(story: str, word: str) -> None:
        assert word in story

    @pytest.mark.parametrize(("at", "word"), [(0, "a"), (1, "b")])
    def test_a_word_has_its_place(at: int, word: str, story: str) -> None:
        assert story[at] == word

    def test_it_is_kept(story: str, tmp_path: object) -> None:
        raise AssertionError("judges more than the story")

    def test_of_something_else() -> None:
        raise AssertionError("judges something else")

    tests = {name: test for name, test in locals().items() if name.startswith("test_")}
    request: Any = SimpleNamespace(module=SimpleNamespace(**tests), fixturename="story")
    fine = passes_its_tests(request)
    assert fine("abc")
    assert not any(fine(story) for story in ("ab", "axa", "cab", 7))


def test_the_last_attempt_counts_however_the_machine_ran(still_s: list[float]) -> None:
    still_s[:] = [1.0] * ATTEMPTS
    told = Story(*["bad"] * (ATTEMPTS - 1), ValueError("last"), "never")
    with pytest.raises(ValueError, match="last"):
        undisturbed(told)
    assert told.ends == ["never"]


def test_calm_is_waited_for_but_not_for_ever(still_s: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    waited_s: list[float] = []
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: sum(waited_s), sleep=waited_s.append))
    still_s[:] = [1.0, 1.0, 0.0]
    wait_for_calm()
    assert sum(waited_s) == 3 * CALM_S
    still_s[:] = [1.0] * 100
    wait_for_calm()
    assert sum(waited_s) == 3 * CALM_S + LONGEST_WAIT_S
