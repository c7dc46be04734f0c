"""The hot side's thermistor shows how a module's cooling works."""

import numpy as np
import pytest

from common.faults.texts import fault_text
from operator_site.devices.hot_side import COLDEST_C, MEMORY_S, MOVED_K, WARMEST_C, HotSide
from sim_sensors.devices.tacttip import ntc_counts
from sim_sensors.physics import finger_plate
from sim_sensors.physics.finger_plate import FingerPlates


@pytest.mark.parametrize(
    ("counts", "fault"),
    [
        (0, "the hot side's thermistor: short circuit"),
        (4095, "the hot side's thermistor: open circuit"),
        (ntc_counts(45.0), "the cooling water is lost: hot side at 45 C, 45 C before"),
        (ntc_counts(WARMEST_C + 0.1), "the cooling water is lost: hot side at 30 C, 30 C before"),
        (ntc_counts(WARMEST_C - 0.1), ""),
        (ntc_counts(COLDEST_C + 0.1), ""),
        (ntc_counts(5.0), "the cooling water is lost or too cold: hot side at 5 C, 5 C before"),
    ],
)
def test_each_fault_of_the_hot_side_is_named(counts: int, fault: str) -> None:
    assert fault_text(HotSide().step(0.0, counts)) == fault


@pytest.mark.parametrize(("rate_k_s", "found"), [(0.2, "lost: hot"), (-0.2, "too cold"), (0.03, ""), (-0.03, "")])
def test_a_block_that_warms_as_without_water_is_found_at_once(rate_k_s: float, found: str) -> None:
    side, faults = HotSide(), []
    for n in range(3000):
        t_s = 0.01 * n
        faults.append(side.step(t_s, ntc_counts(20.0 + rate_k_s * t_s)))
    assert found in fault_text(faults[-1]) if found else not any(faults)
    if found:
        first_s = 0.01 * next(n for n, fault in enumerate(faults) if fault)
        assert MOVED_K / abs(rate_k_s) <= first_s <= 1.2 * MOVED_K / abs(rate_k_s)


def test_a_module_that_was_absent_for_long_starts_again() -> None:
    side = HotSide()
    assert side.step(0.0, ntc_counts(18.0)) is None
    assert side.step(1.0 + MEMORY_S, ntc_counts(24.0)) is None
    assert side.step(1.01 + MEMORY_S, ntc_counts(24.0)) is None


@pytest.mark.long
@pytest.mark.parametrize("water_c", [15.0, 25.0])
@pytest.mark.parametrize("drive", [-1.0, 1.0])
def test_any_drive_with_water_leaves_the_hot_side_normal_by_a_kelvin(
    monkeypatch: pytest.MonkeyPatch, water_c: float, drive: float
) -> None:
    """Cooled or heated for a minute, then the other way."""
    monkeypatch.setattr(finger_plate, "WATER_C", water_c)
    plates, sides = FingerPlates(1, 0), {wrong_k: HotSide() for wrong_k in (-1.0, 1.0)}
    for n in range(12_000):
        plates.step(0.01, np.array([drive if n < 6000 else -drive]))
        for wrong_k, side in sides.items():
            assert side.step(0.01 * n, ntc_counts(float(plates.hot_side_c[0]) + wrong_k)) is None
