"""Effect of a heater on the back of its Peltier element, beside the simulated sensor, which knows more of it."""

import numpy as np
import pytest

from remote_site.thermal.peltier_backside import LEAST_SD_K, LONGEST_S, PeltierBackside
from sim_sensors.physics.thermal_touch import CASE_LEAK_W_K, PELTIER_W_K, STEP_S, SensorSpread, ThermalTouch

AMBIENT_C = 23.0
SENSORS = 8


def session(touches: int, seed: int = 0) -> tuple[PeltierBackside, ThermalTouch]:
    """Sensors that are heated to ambient + 10 K again and again, each time cooled by something for 8 s."""
    rng = np.random.default_rng(seed)
    world = ThermalTouch(SensorSpread.draw(SENSORS, rng), AMBIENT_C, rng)
    back = PeltierBackside()
    for _ in range(touches):
        for _ in range(round(3.0 / STEP_S)):
            drive = np.clip(0.8 * (AMBIENT_C + 10.0 - world.plate_c), -1.0, 1.0)
            world.step(drive, np.zeros(SENSORS))
            back.step(STEP_S, float(drive.mean()), float(world.plate_c.mean()) - AMBIENT_C)
        for _ in range(round(8.0 / STEP_S)):
            world.plate_c += STEP_S * 0.6 * (AMBIENT_C - world.plate_c)
            world.step(np.zeros(SENSORS), np.zeros(SENSORS))
            back.step(STEP_S, 0.0, float(world.plate_c.mean()) - AMBIENT_C)
    return back, world


def leaks_to_k(world: ThermalTouch) -> float:
    """Mean temperature of what the plates leak into, above ambient, K."""
    whole = PELTIER_W_K + CASE_LEAK_W_K
    parts = PELTIER_W_K * world.back_c + CASE_LEAK_W_K * world.case_c
    return float(parts.mean()) / whole - AMBIENT_C


def test_a_sensor_at_rest_is_at_ambient() -> None:
    back = PeltierBackside()
    for _ in range(1000):
        back.step(0.01, 0.0, 0.0)
    assert (back.above_k, back.sd_k) == (0.0, LEAST_SD_K)


@pytest.mark.long
@pytest.mark.parametrize("touches", [1, 3, 6])
def test_reheated_plates_cool_the_backs(touches: int) -> None:
    back, world = session(touches)
    assert leaks_to_k(world) < -0.1
    assert back.above_k == pytest.approx(leaks_to_k(world), abs=0.5 * back.sd_k)


@pytest.mark.long
def test_the_heaters_history_is_forgotten_in_minutes_and_uncertain_until_then() -> None:
    back, _ = session(6)
    assert back.sd_k > 1.1 * LEAST_SD_K
    for _ in range(60_000):
        back.step(0.01, 0.0, 0.0)
    assert back.above_k == pytest.approx(0.0, abs=0.01)
    assert back.sd_k == pytest.approx(LEAST_SD_K, rel=0.01)


def test_cooling_warms_the_back_and_a_gap_in_the_readings_counts_little() -> None:
    back = PeltierBackside()
    back.step(0.1, -1.0, 0.0)
    assert back.above_k > 0.05
    long = PeltierBackside()
    long.step(600.0, 1.0, 0.0)
    short = PeltierBackside()
    short.step(LONGEST_S, 1.0, 0.0)
    assert long.above_k == short.above_k
