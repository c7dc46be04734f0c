import pytest

from sim_sensors.physics.fingertip import HIGH_Z_M, LOW_Z_M, Fingertip, pressing_depth_m


def settle(tip, setpoint_m, stiffness, seconds=0.5, surface_z_m=0.0):
    forces = []
    for _ in range(round(seconds / 0.002)):
        tip.step(0.002, setpoint_m, surface_z_m, stiffness)
        forces.append(tip.force_n)
    return forces


@pytest.mark.parametrize("stiffness", [400.0, 1800.0, 6000.0, 20_000.0])
def test_resting_force_is_that_of_servo_and_object_in_series(stiffness):
    tip = Fingertip(0.002)
    forces = settle(tip, -pressing_depth_m(1.2, stiffness), stiffness)
    assert forces[-1] == pytest.approx(1.2, rel=1e-3)
    assert min(forces) >= 0.0


def test_free_finger_follows_without_overshoot_and_feels_nothing():
    tip = Fingertip(0.006)
    lowest = 1.0
    for _ in range(200):
        tip.step(0.002, 0.001, 0.0, 4000.0)
        lowest = min(lowest, tip.z_m)
    assert tip.force_n == 0.0
    assert lowest > 0.00095
    assert tip.z_m == pytest.approx(0.001, abs=1e-6)


def test_approach_speed_is_the_one_at_the_surface():
    tip, before = Fingertip(0.006), 0.0
    while tip.force_n == 0.0:
        before = -tip.velocity_m_s
        tip.step(0.0005, -0.001, 0.0, 4000.0)
    settle(tip, -0.001, 4000.0)
    assert before > 0.02
    assert tip.approach_m_s == pytest.approx(before, rel=0.1)


def test_lifted_object_surface_meets_earlier():
    tip = Fingertip(0.006)
    settle(tip, 0.0, 4000.0, surface_z_m=0.002)
    assert tip.force_n == pytest.approx(0.002 / (1 / 1000 + 1 / 4000), rel=1e-3)


def test_setpoints_stay_in_the_mechanical_range():
    tip = Fingertip(0.0)
    settle(tip, 1.0, 0.0)
    assert tip.z_m == pytest.approx(HIGH_Z_M, abs=1e-6)
    settle(tip, -1.0, 0.0)
    assert tip.z_m == pytest.approx(LOW_Z_M, abs=1e-6)


def test_long_steps_are_cut_into_stable_ones():
    coarse, fine = Fingertip(0.001), Fingertip(0.001)
    for _ in range(50):
        coarse.step(0.010, -0.0015, 0.0, 6000.0)
    for _ in range(1000):
        fine.step(0.0005, -0.0015, 0.0, 6000.0)
    assert coarse.z_m == pytest.approx(fine.z_m, abs=1e-9)
