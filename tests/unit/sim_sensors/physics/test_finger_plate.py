import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import erfcx

from sim_sensors.physics import finger_plate
from sim_sensors.physics.finger_plate import PLATE_FINGER_M2K_W, FingerPlates


def run(plates: FingerPlates, drive: float, seconds: float, dt_s: float = 0.01) -> FingerPlates:
    for _ in range(round(seconds / dt_s)):
        plates.step(dt_s, np.full(len(plates.plate_c), drive))
    return plates


def test_it_starts_with_a_finger_as_warm_as_people_have_it() -> None:
    plates = FingerPlates(5, seed=0)
    assert np.all((plates.surface_c > 31.5) & (plates.surface_c < 34.0))
    assert np.all(plates.felt_c > plates.surface_c)


@pytest.mark.parametrize(("drive", "rate_k_s"), [(1.0, 4.0), (-1.0, -2.5)])
def test_full_drive_changes_the_plate_as_fast_as_the_device_does(drive: float, rate_k_s: float) -> None:
    plates = FingerPlates(1, seed=0)
    start_c = plates.plate_c[0]
    assert run(plates, drive, 1.0).plate_c[0] - start_c == pytest.approx(rate_k_s, rel=0.05)


def test_skin_follows_the_half_space_solution_while_heat_is_still_in_the_epidermis(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(finger_plate, "PLATE_CAPACITY_J_K", 1e6)  # a plate whose temperature stays
    still, stepped = FingerPlates(1, 0), FingerPlates(1, 0)
    step_k = 5.0
    stepped.plate_c[:] += step_k
    _, _, _, conductivity, capacity, _ = finger_plate.LAYERS[0]
    effusivity = np.sqrt(conductivity * capacity)
    for n in range(1, 31):
        run(still, 0.0, 0.01)
        run(stepped, 0.0, 0.01)
        exact = step_k * (1.0 - erfcx(np.sqrt(0.01 * n) / (PLATE_FINGER_M2K_W * effusivity)))
        if n >= 5:
            assert stepped.surface_c[0] - still.surface_c[0] == pytest.approx(exact, abs=0.04)


def test_heat_put_in_is_heat_found(monkeypatch: pytest.MonkeyPatch) -> None:
    # Without any way out, Joule heat of both halves is all that the plate, finger and hot side gain.
    for name in ("CASE_W_K", "BLOOD_J_M3K"):
        monkeypatch.setattr(finger_plate, name, 0.0)
    monkeypatch.setattr(finger_plate, "HOT_SIDE_K_W", 1e12)
    monkeypatch.setattr(finger_plate, "PLATE_FINGER_M2K_W", 1e6)  # the finger is as good as not there
    plates = FingerPlates(1, seed=0)
    before = plates.plate_c[0] * finger_plate.PLATE_CAPACITY_J_K
    before += plates.hot_side_c[0] * finger_plate.HOT_SIDE_CAPACITY_J_K
    run(plates, 0.5, 2.0)
    after = plates.plate_c[0] * finger_plate.PLATE_CAPACITY_J_K
    after += plates.hot_side_c[0] * finger_plate.HOT_SIDE_CAPACITY_J_K
    current = 0.5 * finger_plate.PELTIER_CURRENT_A
    pumped = 0.0
    trial = FingerPlates(1, seed=0)
    for _ in range(200):
        pumped += 0.01 * current * finger_plate.PELTIER_SEEBECK_V_K * (trial.plate_c[0] - trial.hot_side_c[0])
        run(trial, 0.5, 0.01)
    assert after - before == pytest.approx(pumped + 2.0 * current**2 * finger_plate.PELTIER_OHM, rel=0.01)


def test_the_drive_between_two_steps_counts_by_its_mean() -> None:
    pulsed, even = FingerPlates(1, 0), FingerPlates(1, 0)
    for _ in range(100):
        for drive in (1.0, 1.0, 0.0, 0.0, 0.0):
            pulsed.step(0.002, np.array([drive]))
    run(even, 0.4, 1.0)
    assert pulsed.plate_c[0] == pytest.approx(even.plate_c[0], abs=1e-9)


@pytest.mark.parametrize("dt_s", [0.003, 0.008])
def test_no_time_is_lost_in_steps_that_do_not_divide_10_ms(dt_s: float) -> None:
    odd, even = FingerPlates(1, 0), FingerPlates(1, 0)
    run(odd, 0.4, 1.2, dt_s)
    run(even, 0.4, 1.2)
    assert odd.plate_c[0] == pytest.approx(even.plate_c[0], abs=1e-9)


def test_after_the_drive_is_cut_an_overheated_plate_falls_below_42_within_two_seconds() -> None:
    plates = FingerPlates(1, seed=0)
    while plates.plate_c[0] < 42.5:
        run(plates, 1.0, 0.01)
    assert run(plates, 0.0, 2.0).plate_c[0] < 42.0


def test_the_ntc_lags_and_has_noise_that_its_seed_repeats() -> None:
    def readings(seed: int) -> NDArray[np.float64]:
        plates = FingerPlates(1, seed)
        return np.array([run(plates, 1.0, 0.01).ntc_c[0] for _ in range(50)])

    plates = run(FingerPlates(1, 0), 1.0, 0.5)
    assert plates.plate_c[0] - readings(0)[-1] == pytest.approx(4.2 * finger_plate.NTC_LAG_S, abs=0.06)
    assert np.array_equal(readings(0), readings(0))
    assert not np.array_equal(readings(0), readings(1))


def test_water_keeps_the_hot_side_near_its_own_temperature() -> None:
    assert abs(run(FingerPlates(1, 0), -1.0, 60.0).hot_side_c[0] - finger_plate.WATER_C) < 2.0


@pytest.mark.long
def test_a_finger_without_water_is_cooled_by_the_room_alone_and_its_neighbour_by_water_as_ever() -> None:
    alone, two = FingerPlates(1, 0), FingerPlates(2, 0)
    two.dry[0] = True
    run(alone, -1.0, 60.0)
    run(two, -1.0, 60.0)
    assert two.hot_side_c[0] > finger_plate.WATER_C + 10.0
    assert two.hot_side_c[1] == pytest.approx(alone.hot_side_c[0], abs=1e-9)
    assert two.plate_c[1] == pytest.approx(alone.plate_c[0], abs=1e-9)
    two.dry[0] = False
    assert abs(run(two, 0.0, 60.0).hot_side_c[0] - finger_plate.WATER_C) < 1.0


@pytest.mark.long
def test_without_water_the_joule_heat_of_the_peltiers_leaves_through_the_weak_link_to_the_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(finger_plate, "PELTIER_SEEBECK_V_K", 0.0)
    monkeypatch.setattr(finger_plate, "PELTIER_W_K", 0.0)
    plates = FingerPlates(1, 0)
    plates.dry[0] = True
    joule_w = finger_plate.PELTIER_CURRENT_A**2 * finger_plate.PELTIER_OHM / 2.0
    settled_c = finger_plate.ROOM_C + joule_w * finger_plate.DRY_HOT_SIDE_K_W
    lag_s = finger_plate.DRY_HOT_SIDE_K_W * finger_plate.HOT_SIDE_CAPACITY_J_K
    for seconds in (60.0, 300.0):
        start_c = plates.hot_side_c[0]
        expected_c = settled_c - (settled_c - start_c) * np.exp(-seconds / lag_s)
        assert run(plates, -1.0, seconds).hot_side_c[0] == pytest.approx(expected_c, abs=0.01)


def test_reversed_peltiers_heat_when_they_should_cool() -> None:
    sound, wrong = FingerPlates(1, 0), FingerPlates(1, 0)
    wrong.reversed[0] = True
    run(sound, 0.7, 2.0)
    run(wrong, -0.7, 2.0)
    assert wrong.plate_c[0] == sound.plate_c[0]
    assert wrong.hot_side_c[0] == sound.hot_side_c[0]


def test_the_ntcs_noise_is_as_large_as_it_is_said_to_be() -> None:
    plates = FingerPlates(1000, 0, ntc_noise_k=0.1)
    assert np.std(run(plates, 0.0, 0.1).ntc_c) == pytest.approx(0.1, rel=0.1)
