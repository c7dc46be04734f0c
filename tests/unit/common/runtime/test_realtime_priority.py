"""A loop comes first while it is on time and leaves others enough; what it asked for is what the system then tells."""

import os
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.runtime.realtime_priority import MOST_WORK, RealtimePriority
from common.runtime.scheduling import policy

BUSY, EASY = MOST_WORK + 0.01, MOST_WORK


class System:
    """Gives and takes real-time priority, or refuses it."""

    def __init__(self, *, allows: bool = True) -> None:
        self._allows = allows
        self.asked = 0
        self.first = False

    def take_realtime(self) -> bool:
        self.asked += 1
        self.first = self._allows
        return self._allows

    def take_ordinary(self) -> None:
        assert self.first, "only who came first can stand back"
        self.first = False

    def precedence(self) -> RealtimePriority:
        return RealtimePriority(self.take_realtime, self.take_ordinary)


@given(st.lists(st.tuples(st.booleans(), st.none() | st.floats(0.0, 1.0)), max_size=30))
def test_it_comes_first_just_while_it_is_known_to_be_on_time_and_to_leave_enough(
    looks: list[tuple[bool, float | None]],
) -> None:
    assert 0.5 < MOST_WORK < 1.0, "a site needs half of a processor"
    system = System()
    precedence = system.precedence()
    for holds_rate, works in looks:
        assert precedence.look(holds_rate, works) == system.first == precedence.first
        assert system.first == (holds_rate and works is not None and works <= MOST_WORK)


def test_it_is_asked_for_once_where_it_is_refused() -> None:
    system = System(allows=False)
    precedence = system.precedence()
    assert not any([precedence.look(True, EASY), precedence.look(False, EASY), precedence.look(True, EASY)])
    assert system.asked == 1


def test_a_thread_that_was_given_another_policy_by_somebody_else_keeps_it() -> None:
    if policy() != os.SCHED_OTHER:
        pytest.skip("the tests themselves run with a policy of their own")
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    try:
        assert not RealtimePriority().look(True, EASY)
        assert os.sched_getscheduler(0) == os.SCHED_BATCH
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def test_real_time_priority_that_somebody_else_gave_is_told_and_never_taken() -> None:
    code = f"""
import os, sys
from common.runtime.realtime_priority import RealtimePriority
try:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
except PermissionError:
    sys.exit("denied")
precedence = RealtimePriority()
print(precedence.first, precedence.look(True, {EASY}), precedence.look(False, None), os.sched_getscheduler(0))
"""
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    if told.stderr == "denied\n":
        pytest.skip("no real-time policy may be set here")
    assert told.stdout.split() == ["True", "True", "True", str(os.SCHED_FIFO)]
