"""A plate that takes more and more heat at the same reading is found; a sound one is not."""

from collections.abc import Callable

import pytest

from common.faults.fault import FaultCode
from operator_site.safety.plate_following import CHECK_S, PlateFollowing
from operator_site.safety.plate_load import FINGER_AWAY_C, LOAD, RISE_K_S, SETTLE_S, SMOOTH_S, STEADY_PER_S, PlateLoad

OfTime = Callable[[float], float]
HELD_C = 38.0


def found_s(load: PlateLoad, power_k_s: OfTime, reading_c: OfTime, until_s: float) -> float | None:
    """When the plate is found to take too much heat, s from now; None until the end."""
    last_c = reading_c(-CHECK_S)
    for tick in range(round(until_s / CHECK_S)):
        t_s = tick * CHECK_S
        plate_c = reading_c(t_s)
        if load.step(CHECK_S, power_k_s(t_s), (plate_c - last_c) / CHECK_S, plate_c):
            return t_s
        last_c = plate_c
    return None


def always(value: float) -> OfTime:
    return lambda _t_s: value


def finger_takes(step_k: float, since_s: float) -> float:
    """Heat that a finger takes some time after its plate became hotter by a step, K/s."""
    return STEADY_PER_S * step_k + sum(
        gain * step_k * (1.0 - CHECK_S / fades_s) ** round(since_s / CHECK_S) for gain, fades_s in LOAD
    )


@pytest.mark.parametrize("rise_k_s", [0.9 * RISE_K_S, 1.3 * RISE_K_S])
def test_more_heat_at_a_held_reading_is_found_from_the_limit_on(rise_k_s: float) -> None:
    load = PlateLoad()
    assert found_s(load, always(0.8), always(HELD_C), SETTLE_S + 1.0) is None
    seen_s = found_s(load, always(0.8 + rise_k_s), always(HELD_C), 10.0 * SMOOTH_S)
    assert (seen_s is not None) == (rise_k_s > RISE_K_S)


def test_a_finger_that_becomes_warm_takes_less_and_less() -> None:
    load = PlateLoad()
    assert found_s(load, lambda t_s: 2.0 - 0.05 * t_s, always(HELD_C), 30.0) is None


@pytest.mark.parametrize("hotter_k", [5.0, -5.0])
def test_the_heat_of_another_temperature_is_explained(hotter_k: float) -> None:
    load, changes_s = PlateLoad(), 2.0
    base_k_s = 0.5 + STEADY_PER_S * (33.0 - HELD_C)
    assert found_s(load, always(base_k_s), always(33.0), SETTLE_S + 3.0) is None

    def reading_c(t_s: float) -> float:
        return 33.0 + hotter_k * min(max(t_s / changes_s, 0.0), 1.0)

    def power_k_s(t_s: float) -> float:
        ramps = [
            finger_takes(hotter_k / 20, t_s - changes_s * part / 20)
            for part in range(20)
            if t_s >= changes_s * part / 20
        ]
        return base_k_s + sum(ramps) + (hotter_k / changes_s if t_s < changes_s else 0.0)

    assert found_s(load, power_k_s, reading_c, 40.0) is None


@pytest.mark.parametrize("rest_c", [FINGER_AWAY_C - 1.0, FINGER_AWAY_C + 1.0])
def test_only_after_a_cold_rest_without_drive_a_plate_is_judged_anew(rest_c: float) -> None:
    load = PlateLoad()
    assert found_s(load, always(0.5), always(33.0), SETTLE_S + 3.0) is None
    assert found_s(load, always(0.0), lambda t_s: max(rest_c, 33.0 - t_s), 40.0) is None
    found = found_s(load, always(2.0), always(rest_c), SETTLE_S + 10.0)
    assert (found is None) == (rest_c < FINGER_AWAY_C)


def test_the_fault_is_named_last() -> None:
    follow, codes = PlateFollowing(), []
    for tick in range(3000):
        reading_c = HELD_C + 0.02 * (tick // 5 % 2)
        codes.append(follow.step(CHECK_S, 0.2 + 0.01 * max(0.0, tick * CHECK_S - 8.0), reading_c))
    found = [code for code in codes if code]
    assert found[0] == FaultCode.PLATE_TAKES_HEAT
