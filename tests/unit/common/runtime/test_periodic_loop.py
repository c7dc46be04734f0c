import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.runtime.periodic_loop import PeriodicLoop


class Clock:
    """Time that passes by sleeping, and by `work`."""

    def __init__(self, sleep_error: float = 0.0) -> None:
        self.t = 100.0
        self.slept: list[float] = []
        self._error = sleep_error

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.t += seconds + self._error


def loop_on(clock: Clock, period_s: float = 0.002) -> PeriodicLoop:
    return PeriodicLoop(period_s, now=lambda: clock.t, sleep=clock.sleep)


def test_sleep_errors_do_not_add_up() -> None:
    clock = Clock(sleep_error=50e-6)
    loop = loop_on(clock)
    for _ in range(1000):
        assert loop.wait() == pytest.approx(50e-6, abs=1e-9)
    assert clock.t == pytest.approx(102.0 + 50e-6)
    assert (loop.ticks, loop.overruns) == (1000, 0)


def test_no_burst_after_a_stall() -> None:
    clock = Clock()
    loop = loop_on(clock)
    loop.wait()
    clock.t += 1.0
    assert loop.wait() == pytest.approx(0.998)
    clock.slept.clear()
    for _ in range(5):
        loop.wait()
    assert clock.slept == pytest.approx([0.002] * 5)
    assert (loop.overruns, loop.missed) == (1, 499)
    assert loop.late_max_s == pytest.approx(0.998)


@pytest.mark.parametrize(
    ("work_s", "late_s", "next_s", "missed"), [(0.003, 0.001, 100.006, 0), (0.0047, 0.0027, 100.008, 1)]
)
def test_ticks_keep_their_grid_after_a_late_one(work_s: float, late_s: float, next_s: float, missed: int) -> None:
    clock = Clock()
    loop = loop_on(clock)
    loop.wait()
    clock.t += work_s
    assert loop.wait() == pytest.approx(late_s)
    loop.wait()
    assert clock.t == pytest.approx(next_s)
    assert (loop.overruns, loop.missed) == (missed, missed)


@given(st.lists(st.floats(1e-6, 0.5), min_size=1, max_size=60), st.floats(0.01, 1.0))
def test_quantiles_of_lateness_are_right_within_a_bucket(late_s: list[float], quantile: float) -> None:
    clock = Clock()
    loop = loop_on(clock, period_s=1.0)
    assert loop.late_us(quantile) == 0.0
    measured = []
    for late in late_s:
        clock.t = loop._deadline + late
        measured.append(loop.wait() * 1e6)
    found = loop.late_us(quantile)
    assert any(found <= true * 1.0001 and true <= max(1.0, found) * 1.07 for true in measured)
    assert loop.late_us(1.0) <= loop.late_max_s * 1e6 * 1.0001
