"""Eq. 1, Eq. 2 and damped impulses as motor speed, and the voltage for it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM
from common.messages import Event, EventKind, ExplorationMode
from operator_site.motor_drive import MOTOR, RPM_TO_RAD_S, motor_mv
from operator_site.vibration import TAP_HOLD_S, TAP_S, FingerVibration, PlayedEvents, Surface

PVC = Surface(k_tap=4000.0, b_tap_per_s=30.0, k_stroke_v=2000.0, k_stroke_f=60.0, b_groove_per_s=60.0)
ROUGH = Surface(k_tap=4000.0, b_tap_per_s=30.0, k_stroke_v=5000.0, k_stroke_f=120.0, b_groove_per_s=60.0)
DT = 0.002


def tap(speed_m_s: float, ident: int = 1) -> Event:
    return Event(ident, EventKind.TAP, 1, 0, speed_m_s)


def groove(amplitude: float, ident: int = 2) -> Event:
    return Event(ident, EventKind.GROOVE, 1, 0, amplitude)


def rpm(rad_s: float) -> float:
    return rad_s / RPM_TO_RAD_S


def test_tap_is_eq_1_and_ends():
    finger = FingerVibration()
    for tick in range(100):
        t_s = tick * DT
        out = finger.step(t_s, ExplorationMode.TAPPING, 0.0, 1.0, surface=PVC, events=[tap(0.2)] if tick == 0 else [])
        wanted = rpm(4000.0 * 0.2 * math.exp(-30.0 * t_s))
        if wanted > 4000.0:  # above the floor and the certain part of the tap
            assert out == pytest.approx(wanted)
        if t_s > TAP_S:
            assert out == 0.0


@pytest.mark.parametrize("speed", [0.005, 0.03, 0.1])
def test_every_tap_brings_the_motor_to_the_floor(speed):
    finger, omega, fastest = FingerVibration(), 0.0, 0.0
    for tick in range(100):
        events = [tap(speed)] if tick == 0 else []
        out = finger.step(
            tick * DT, ExplorationMode.TAPPING, 0.0, 1.0, surface=Surface(k_tap=1.0, b_tap_per_s=40.0), events=events
        )
        assert out >= MOTOR_FLOOR_RPM or tick * DT > TAP_HOLD_S
        omega += (rpm(0.0) + out - omega) * (1.0 - math.exp(-DT / 0.05))  # a motor with a time constant of 50 ms
        fastest = max(fastest, omega)
    assert fastest >= MOTOR_FLOOR_RPM * 0.99


def test_a_finger_laid_down_gently_is_no_tap():
    out = FingerVibration().step(0.0, ExplorationMode.TAPPING, 0.0, 1.0, surface=PVC, events=[tap(0.004)])
    assert out == 0.0


def test_stroke_is_eq_2_and_gated_by_mode():
    for mode in ExplorationMode:
        out = FingerVibration().step(0.0, mode, -0.06, 1.2, surface=ROUGH)
        assert out == (pytest.approx(rpm(5000 * 0.06 + 120 * 1.2)) if mode is ExplorationMode.STROKING else 0.0)


def test_no_vibration_at_rest_however_hard_it_presses():
    finger = FingerVibration()
    assert all(finger.step(i * DT, ExplorationMode.QUIESCENT, 0.0, 10.0, surface=ROUGH) == 0.0 for i in range(500))


def test_grooves_add_damped_impulses():
    finger, expected = FingerVibration(), []
    for tick in range(100):
        events = [groove(400.0, tick)] if tick in {0, 10} else []
        out = finger.step(tick * DT, ExplorationMode.STROKING, 0.1, 1.0, surface=ROUGH, events=events)
        impulses = sum(400.0 * math.exp(-60.0 * (tick - k) * DT) for k in (0, 10) if tick >= k)
        expected.append(rpm(5000 * 0.1 + 120 + impulses))
        assert out == pytest.approx(min(MOTOR_MAX_RPM, expected[-1]))
    assert max(expected) > 9000.0


def test_free_ends_everything():
    finger = FingerVibration()
    finger.step(0.0, ExplorationMode.STROKING, 0.1, 1.0, surface=ROUGH, events=[tap(0.5), groove(400.0)])
    assert finger.step(DT, ExplorationMode.FREE, 0.1, 1.0, surface=ROUGH) == 0.0
    assert finger.step(2 * DT, ExplorationMode.QUIESCENT, 0.1, 1.0, surface=ROUGH) == 0.0


def test_floor_has_hysteresis():
    finger = FingerVibration()
    level = [0.30, 0.40, 0.30, 0.20, 0.30]
    shown = [
        finger.step(i * DT, ExplorationMode.STROKING, share * MOTOR_FLOOR_RPM * RPM_TO_RAD_S / 2000.0, 0.0, surface=PVC)
        for i, share in enumerate(level)
    ]
    assert shown == [0.0, MOTOR_FLOOR_RPM, MOTOR_FLOOR_RPM, 0.0, 0.0]


def test_material_event_moves_nothing():
    event = Event(5, EventKind.MATERIAL, 1, 0, 0.99, "pvc")
    assert FingerVibration().step(0.0, ExplorationMode.QUIESCENT, 0.0, 1.0, surface=PVC, events=[event]) == 0.0


def test_unknown_decay_still_decays():
    finger = FingerVibration()
    bare = Surface(k_stroke_v=2000.0)
    first = finger.step(0.0, ExplorationMode.STROKING, 0.0, 0.0, surface=bare, events=[groove(900.0)])
    assert first > 8000.0
    assert finger.step(0.2, ExplorationMode.STROKING, 0.0, 0.0, surface=bare) == 0.0


@given(st.lists(st.lists(st.integers(0, 40), max_size=6), max_size=20))
def test_each_event_is_played_once(packets):
    played = PlayedEvents()
    seen = [event.ident for packet in packets for event in played.new([groove(1.0, ident) for ident in packet])]
    assert len(seen) == len(set(seen))
    assert set(seen) == {ident for packet in packets for ident in packet}


def test_memory_of_events_is_bounded_but_longer_than_any_packet():
    played = PlayedEvents()
    for ident in range(2000):
        assert len(played.new([groove(1.0, k) for k in range(max(0, ident - 23), ident + 1)])) == 1
    assert len(played._seen) <= 512


@given(
    st.lists(
        st.tuples(
            st.sampled_from(list(ExplorationMode)), st.floats(-1.0, 1.0), st.floats(0.0, 10.0), st.floats(0.0, 1000.0)
        ),
        max_size=30,
    )
)
def test_speed_is_zero_or_felt(samples):
    finger = FingerVibration()
    for i, (mode, speed, force, value) in enumerate(samples):
        out = finger.step(i * DT, mode, speed, force, surface=ROUGH, events=[tap(value), groove(value)])
        assert out == 0.0 or MOTOR_FLOOR_RPM <= out <= MOTOR_MAX_RPM


def test_voltage_holds_the_speed():
    assert motor_mv(10_000.0) == pytest.approx(1410, abs=10)
    assert pytest.approx(0.35, abs=0.01) == MOTOR.start_v
    assert pytest.approx(0.05, abs=0.001) == MOTOR.time_constant_s
    assert [motor_mv(v) for v in (0.0, -1.0, math.nan, math.inf)] == [0, 0, 0, 0]
    assert motor_mv(1e9) == motor_mv(MOTOR_MAX_RPM)
    for speed in np.linspace(500.0, 10_000.0, 20):
        omega = 0.0
        for _ in range(2000):  # the motor's own equation, integrated
            current = (motor_mv(speed) / 1000.0 - 6.4e-4 * omega) / 10.8
            omega += (6.4e-4 * current - 2.2e-8 * omega - 2.1e-5) / 3e-9 * 5e-4
        assert rpm(omega) == pytest.approx(speed, abs=10.0)
