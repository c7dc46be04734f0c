"""A heater that holds its offset and stops in doubt, and plates of different warmth on one hand."""

from itertools import pairwise

import pytest

from common.fingers import FINGERS
from common.limits import DOSE_ABOVE_C
from common.safety.thermal_dose import ThermalDose
from common.wire.messages import ThermalReason
from remote_site.thermal.heater_control import OFFSETS_K, STAGGER_K, HeaterControl, next_offset_k
from tests.unit.remote_site.made_touches import AMBIENT_C

PREHEATS_K = [OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K]
"""Of the first, second, ... finger in use."""


def plate(
    control: HeaterControl, seconds: float, lag_s: float, ambient_c: float = AMBIENT_C, dose: ThermalDose | None = None
) -> tuple[float, float]:
    """Last and highest temperature of a plate of 5.2 K/s at full drive, 2 mW/K to air, read through a lag."""
    true = read = ambient_c
    worst = 0.0
    for n in range(round(100 * seconds)):
        drive = control.step(0.01 * n, read, ambient_c, False)
        if dose is not None:
            assert not dose.step(0.01 * n, read), f"the dose is spent after {0.01 * n:.1f} s"
        true += 0.01 * (5.2 * drive - 0.03 * (true - ambient_c))
        read += 0.01 / lag_s * (true - read)
        worst = max(worst, true)
    return true, worst


@pytest.mark.parametrize("offset_k", sorted(set(PREHEATS_K)))
@pytest.mark.parametrize("lag_s", [0.2, 0.3, 0.5])
def test_the_plate_reaches_its_offset_without_overshoot(offset_k: float, lag_s: float) -> None:
    true, worst = plate(HeaterControl(offset_k), 6.0, lag_s)
    assert true == pytest.approx(AMBIENT_C + offset_k, abs=0.15)
    assert worst < AMBIENT_C + offset_k + 0.6


@pytest.mark.parametrize("offset_k", OFFSETS_K)
@pytest.mark.parametrize("ambient_c", [24.4, 31.0, 35.0, 39.0])
def test_in_a_warm_room_the_waiting_plate_takes_no_dose(ambient_c: float, offset_k: float) -> None:
    """A spent dose would turn the heater off, and the plate would be as warm as the room for most of the time."""
    true, _ = plate(HeaterControl(offset_k), 60.0, 0.3, ambient_c, ThermalDose())
    assert true == pytest.approx(min(ambient_c + offset_k, DOSE_ABOVE_C), abs=0.15)


def test_the_heater_is_off_in_contact_and_when_uncertain() -> None:
    control = HeaterControl()
    assert control.step(0.0, 25.0, 23.0, False) == 1.0
    assert control.step(0.1, 25.0, 23.0, True) == 0.0
    assert control.step(0.2, 25.0, 23.0, False, ThermalReason.SENSOR_OPEN) == 0.0
    assert control.step(0.3, float("nan"), 23.0, False) == 0.0
    assert control.step(0.4, 25.0, float("nan"), False) == 0.0
    assert control.step(0.5, 42.5, 23.0, False) == 0.0


def test_the_next_offset_never_passes_42_c() -> None:
    assert next_offset_k(10.0, 23.0) == 17.0
    assert next_offset_k(17.0, 23.0) == 3.0
    assert next_offset_k(3.0, 23.0) == 10.0
    assert next_offset_k(10.0, 26.0) == 3.0


def test_there_is_a_difference_between_any_two_neighbours_and_one_for_each_finger() -> None:
    assert len(STAGGER_K) == len(FINGERS)
    assert all(abs(a - b) >= 3.0 for a, b in pairwise(STAGGER_K))
    assert all(preheat_k >= 3.0 for preheat_k in PREHEATS_K)
