import numpy as np
import pytest

from sim_sensors.physics.motor import TIME_CONSTANT_S, VibrationMotors


def run(volts: float, seconds: float, motors: VibrationMotors | None = None, dt_s: float = 0.002) -> VibrationMotors:
    motors = motors or VibrationMotors(1)
    for _ in range(round(seconds / dt_s)):
        motors.step(dt_s, np.array([volts]))
    return motors


def test_rated_voltage_gives_ten_thousand_rpm() -> None:
    assert run(1.41, 1.0).rpm[0] == pytest.approx(10_000, rel=0.01)


@pytest.mark.parametrize(("volts", "turns"), [(0.0, False), (0.35, False), (0.38, False), (0.40, True)])
def test_it_starts_only_above_stiction(volts: float, turns: bool) -> None:
    assert bool(run(volts, 1.0).rpm[0] > 0.0) is turns


def test_friction_is_less_than_stiction_so_a_turning_motor_goes_on_where_a_still_one_does_not_start() -> None:
    assert run(0.37, 2.0, run(1.0, 0.2)).rpm[0] > 50.0


def test_speed_rises_with_the_mechanical_time_constant() -> None:
    assert pytest.approx(0.050, rel=0.01) == TIME_CONSTANT_S
    share = run(1.41, TIME_CONSTANT_S, dt_s=TIME_CONSTANT_S / 50).rpm[0] / run(1.41, 2.0).rpm[0]
    assert share == pytest.approx(1 - np.exp(-1), abs=0.005)


def test_without_voltage_it_brakes_to_a_stop_and_stays() -> None:
    motors = run(1.41, 1.0)
    run(0.0, 0.07, motors)
    assert motors.rpm[0] < 2740.0
    run(0.0, 0.3, motors)
    assert motors.rpm[0] == 0.0


def test_the_length_of_a_step_makes_no_difference() -> None:
    assert run(1.0, 0.1, dt_s=0.01).rpm[0] == pytest.approx(run(1.0, 0.1, dt_s=0.0005).rpm[0], rel=1e-9)


def test_each_motor_has_its_own_voltage() -> None:
    motors = VibrationMotors(5)
    for _ in range(300):
        motors.step(0.002, np.array([0.0, 0.5, 1.0, 1.41, 3.0]))
    assert motors.rpm[0] == 0.0
    assert np.all(np.diff(motors.rpm) > 500.0)
