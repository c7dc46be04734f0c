"""A reading that rises too slowly for its heat is found, and only after a while of strong drive."""

import math

import pytest

from remote_site.safety.slow_heating import LEAST_RATE_K_S, SETTLE_S, STRONG_DRIVE, SlowHeating

DT_S = 0.125


def found(drive: float, rate_k_s: float, seconds: float, heating: SlowHeating | None = None) -> int:
    heating = heating or SlowHeating()
    return sum(heating.step(DT_S, drive, rate_k_s) for _ in range(round(seconds / DT_S)))


@pytest.mark.parametrize("drive", [STRONG_DRIVE, 0.75, 1.0])
def test_the_least_rate_is_in_proportion_to_the_drive(drive: float) -> None:
    least_k_s = LEAST_RATE_K_S * drive
    assert found(drive, least_k_s, 10.0) == 0
    assert found(drive, math.nextafter(least_k_s, 0.0), SETTLE_S) == 0
    assert found(drive, math.nextafter(least_k_s, 0.0), SETTLE_S + DT_S) == 1


@pytest.mark.parametrize("drive", [math.nextafter(STRONG_DRIVE, 0.0), 0.0, -1.0])
def test_a_weak_drive_and_cooling_are_not_judged_and_begin_the_time_anew(drive: float) -> None:
    assert found(drive, -5.0, 10.0) == 0
    heating = SlowHeating()
    for _ in range(3):
        assert found(1.0, 0.0, SETTLE_S, heating) == 0
        heating.step(DT_S, drive, 0.0)


def test_it_is_found_once_for_each_time_of_settling() -> None:
    assert found(1.0, 0.0, 4.0 * (SETTLE_S + DT_S)) == 4
