"""A broken force sensor is named within its time; a sound one never is, on any object."""

from collections.abc import Callable, Iterator
from itertools import islice

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.faults.fault import Fault, FaultCode
from remote_site.devices.force_sensor_fault import FROZEN_S, HELD_M, LOADED_N, PERSIST_S, ForceSensorFault
from remote_site.safety.sliding_extrema import MEMORY_S
from tests.unit.remote_site.servo_finger import HOVER_M, TICK_S, Seen, follow, presses


def watch(
    seen: Iterator[Seen], lie: Callable[[Seen], float] = lambda now: now.force_n
) -> Iterator[tuple[Seen, Fault | None]]:
    sensor, before_s = ForceSensorFault(), -TICK_S
    for now in seen:
        yield now, sensor.step(now.t_s - before_s, lie(now), now.height_m)
        sensor.commanded(now.t_s, now.set_m, released=False)
        before_s = now.t_s


def hold(height_m: float, seconds: float, speed_m_s: float = 0.05) -> Iterator[float]:
    """Down or up to a height, and there it stays."""
    for tick in range(round(seconds / TICK_S)):
        yield max(height_m, HOVER_M - speed_m_s * tick * TICK_S)


@pytest.mark.long
@settings(max_examples=25)
@given(st.floats(100.0, 100_000.0), st.integers(0, 2**32), st.integers(1, 8))
def test_a_sound_sensor_is_never_a_fault(stiffness_n_m: float, seed: int, late: int) -> None:
    for _, fault in watch(follow(presses(seed, 6.0), stiffness_n_m, seed, late)):
        assert fault is None


@pytest.mark.parametrize("stiffness_n_m", [200.0, 1000.0, 30_000.0])
def test_a_sensor_that_freezes_under_load_is_named(stiffness_n_m: float) -> None:
    frozen_n = -1.0

    def lie(now: Seen) -> float:
        nonlocal frozen_n
        if now.t_s < 1.5:
            frozen_n = now.force_n
        return frozen_n

    found_s = next(now.t_s for now, fault in watch(follow(hold(-0.003, 3.0), stiffness_n_m, 1), lie) if fault)
    assert frozen_n >= LOADED_N
    assert 0.0 < found_s - 1.5 <= FROZEN_S + 3.0 * TICK_S


@pytest.mark.parametrize("stiffness_n_m", [1000.0, 30_000.0])
def test_a_silent_sensor_is_named_when_something_holds_the_finger(stiffness_n_m: float) -> None:
    found = watch(follow(hold(-0.003, 3.0), stiffness_n_m, 1), lambda now: 0.0)
    now, fault = next((now, fault) for now, fault in found if fault)
    assert fault is not None
    assert fault.code is FaultCode.FORCE_SENSOR_DEAD
    assert fault.detail == "0.00 N"
    assert fault.limit == HELD_M * 1e3 < (fault.value or 0.0)
    arrived_s = (HOVER_M + 0.003) / 0.05
    assert now.t_s <= arrived_s + MEMORY_S + PERSIST_S + 0.02


def test_a_free_finger_may_have_a_silent_sensor() -> None:
    for _, fault in watch(follow(presses(3, 5.0), 0.0, 3), lambda now: 0.0):
        assert fault is None


@pytest.mark.parametrize(("bias_n", "deepest_m"), [(0.5, HOVER_M), (1.0, HOVER_M), (1.0, -0.003), (3.0, -0.003)])
def test_force_without_contact_is_named(bias_n: float, deepest_m: float) -> None:
    pressed = follow(hold(deepest_m, 3.0), 1000.0, 1)
    found = watch(pressed, lambda now: now.force_n + bias_n * (now.t_s >= 1.5))
    now, fault = next((now, fault) for now, fault in found if fault)
    assert fault is not None
    assert fault.code is FaultCode.FORCE_SENSOR_BIASED
    assert 0.0 < now.t_s - 1.5 <= PERSIST_S + 0.03


def test_motion_of_a_released_finger_is_no_evidence_on_its_sensor() -> None:
    sensor = ForceSensorFault()
    for tick in range(1000):
        assert sensor.step(TICK_S, 0.0, HOVER_M) is None
        sensor.commanded(tick * TICK_S, HOVER_M - 0.003, released=True)
    for tick in range(1000, 1000 + round(MEMORY_S / TICK_S)):
        assert sensor.step(TICK_S, 0.0, HOVER_M) is None
        sensor.commanded(tick * TICK_S, HOVER_M - 2.0 * HELD_M, released=False)


def test_pauses_do_not_count_as_time_that_a_reading_was_the_same() -> None:
    sensor = ForceSensorFault()
    for _ in range(5):
        assert sensor.step(3.0, 1.0, 0.0) is None
    assert sensor.step(float("nan"), 1.0, 0.0) is None


def test_the_fault_ends_when_the_sensor_is_sound_again() -> None:
    faults = list(
        islice(
            watch(follow(hold(-0.003, 4.0), 1000.0, 1), lambda now: 1.0 if 1.5 < now.t_s < 2.5 else now.force_n), 2000
        )
    )
    assert any(fault for _, fault in faults)
    assert faults[-1][1] is None
