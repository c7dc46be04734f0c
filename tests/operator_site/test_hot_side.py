"""What the hot side's thermistor tells of a module's cooling."""

import numpy as np
import pytest

from operator_site.hot_side import COLDEST_C, WARMEST_C, hot_side_fault
from sim_sensors import finger_plate
from sim_sensors.finger_plate import FingerPlates
from sim_sensors.tacttip import ntc_counts


@pytest.mark.parametrize(
    ("counts", "fault"),
    [
        (0, "the hot side's thermistor: short circuit"),
        (4095, "the hot side's thermistor: open circuit"),
        (ntc_counts(45.0), "the cooling water is lost: hot side at 45 C"),
        (ntc_counts(WARMEST_C + 0.1), "the cooling water is lost: hot side at 30 C"),
        (ntc_counts(WARMEST_C - 0.1), ""),
        (ntc_counts(COLDEST_C + 0.1), ""),
        (ntc_counts(5.0), "the cooling water is too cold: hot side at 5 C"),
    ],
)
def test_it_is_named_what_is_wrong(counts: int, fault: str) -> None:
    assert hot_side_fault(counts) == fault


@pytest.mark.parametrize("water_c", [15.0, 25.0])
@pytest.mark.parametrize("drive", [-1.0, 1.0])
def test_whatever_a_plate_is_driven_with_water_keeps_the_hot_side_normal_with_a_kelvin_to_spare(
    monkeypatch: pytest.MonkeyPatch, water_c: float, drive: float
) -> None:
    monkeypatch.setattr(finger_plate, "WATER_C", water_c)
    plates = FingerPlates(1, 0)
    for _ in range(6000):
        plates.step(0.01, np.array([drive]))
        for wrong_k in (-1.0, 1.0):
            assert hot_side_fault(ntc_counts(float(plates.hot_side_c[0]) + wrong_k)) == ""
