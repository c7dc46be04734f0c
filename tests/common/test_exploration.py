"""The mode machine: contact at once, taps of 0.15 s, strokes with hysteresis."""

from hypothesis import given
from hypothesis import strategies as st

from common.exploration import CONTACT_ON_N, Exploration
from common.messages import ExplorationMode
from common.motion_estimate import MotionEstimate

FREE, TAPPING, QUIESCENT, STROKING = ExplorationMode


def run(steps):
    machine, modes = Exploration(), []
    for k, (force, x, speed) in enumerate(steps):
        modes.append(machine.step(0.002 * k, force, x, 0.0, speed, approach_m_s=0.04))
    return machine, modes


def test_contact_is_immediate_and_has_hysteresis():
    machine, modes = run([(0.29, 0, 0), (0.30, 0, 0), (0.16, 0, 0), (0.149, 0, 0), (0.29, 0, 0)])
    assert modes == [FREE, TAPPING, TAPPING, FREE, FREE]
    assert machine.approach_m_s == 0.04


def test_a_tap_lasts_150_ms_then_rests():
    _, modes = run([(1.0, 0, 0)] * 100)
    assert modes[74] is TAPPING
    assert modes[76:] == [QUIESCENT] * 24


def test_stroking_needs_distance_and_speed():
    rest = [(1.0, 0.0, 0.0)] * 100
    assert run([*rest, (1.0, 0.0019, 0.05)])[1][-1] is QUIESCENT
    assert run([*rest, (1.0, 0.0021, 0.009)])[1][-1] is QUIESCENT
    assert run([*rest, (1.0, 0.0021, 0.011)])[1][-1] is STROKING


def test_a_reversal_is_one_stroke_and_a_rest_ends_it():
    stroke = [(1.0, 0.0, 0.0)] * 100 + [(1.0, 0.01, 0.05)]
    assert run(stroke + [(1.0, 0.01, 0.001)] * 20 + [(1.0, 0.01, 0.05)])[1][-1] is STROKING
    assert run(stroke + [(1.0, 0.01, 0.001)] * 30)[1][-1] is QUIESCENT


@given(
    st.lists(st.tuples(st.floats(-1, 6) | st.just(float("nan")), st.floats(-0.1, 0.1), st.floats(0, 0.3)), max_size=200)
)
def test_every_mode_has_its_reason(steps):
    machine, touched, began_at, x_tap = Exploration(), False, 0.0, 0.0
    for k, (force, x, speed) in enumerate(steps):
        t = 0.02 * k
        before = machine.mode
        mode = machine.step(t, force, x, 0.0, speed)
        assert machine.contact == (mode is not FREE)
        if machine.began:
            assert force >= CONTACT_ON_N
            touched, began_at, x_tap = True, t, x
        if mode is TAPPING:
            assert touched
            assert t - began_at < 0.15
        if mode is STROKING and before is not STROKING:
            assert abs(x - x_tap) > 2e-3
            assert speed > 10e-3
        if not force >= 0.15:
            assert mode is FREE


def test_velocity_survives_quantisation():
    motion = MotionEstimate()
    speeds = []
    for k in range(100):
        t = 0.002 * k
        motion.step(t, round(0.05 * t / 2e-5) * 2e-5, 0.0, round(-0.03 * t / 5e-6) * 5e-6)
        speeds.append(motion.speed_m_s)
    assert max(abs(v - 0.05) for v in speeds[10:]) < 0.002
    assert abs(motion.approach_m_s - 0.03) < 0.002
