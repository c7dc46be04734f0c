"""A loop has real-time priority while it is on time and leaves enough to others; the system confirms it."""

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
def test_a_loop_has_real_time_priority_only_while_on_time_and_below_its_share(
    looks: list[tuple[bool, float | None]],
) -> None:
    assert 0.5 < MOST_WORK < 1.0, "a site needs half of a processor"
    system = System()
    precedence = system.precedence()
    for holds_rate, works in looks:
        assert precedence.look(holds_rate, works) == system.first == precedence.first
        assert system.first == (holds_rate and works is not None and works <= MOST_WORK)


def test_a_refused_priority_is_requested_once() -> None:
    system = System(allows=False)
    precedence = system.precedence()
    assert not any([precedence.look(True, EASY), precedence.look(False, EASY), precedence.look(True, EASY)])
    assert system.asked == 1


def test_a_policy_set_from_outside_is_kept() -> None:
    if policy() != os.SCHED_OTHER:
        pytest.skip("the tests themselves run with a policy of their own")
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    try:
        assert not RealtimePriority().look(True, EASY)
        assert os.sched_getscheduler(0) == os.SCHED_BATCH
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def test_real_time_priority_set_from_outside_is_reported_and_kept() -> None:
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
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    if result.stderr == "denied\n":
        pytest.skip("no real-time policy may be set here")
    assert result.stdout.split() == ["True", "True", "True", str(os.SCHED_FIFO)]
