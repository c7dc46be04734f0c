"""Eq. 1, Eq. 2 and damped impulses as motor speed."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.exploration.exploration_mode import REST_S
from common.limits import MOTOR_FLOOR_RPM, MOTOR_MAX_RPM
from common.wire.messages import Event, EventKind, ExplorationMode
from operator_site.vibration.motor_drive import MOTOR, RPM_TO_RAD_S
from operator_site.vibration.vibration import TAP_HOLD_S, TAP_S, FingerVibration, PlayedEvents, Surface

PVC = Surface(k_tap=4000.0, b_tap_per_s=30.0, k_stroke_v=2000.0, k_stroke_f=60.0, b_groove_per_s=60.0)
ROUGH = Surface(k_tap=4000.0, b_tap_per_s=30.0, k_stroke_v=5000.0, k_stroke_f=120.0, b_groove_per_s=60.0)
DT = 0.002


def tap(speed_m_s: float, ident: int = 1) -> Event:
    return Event(ident, EventKind.TAP, 1, 0, 0, speed_m_s)


def groove(amplitude: float, ident: int = 2) -> Event:
    return Event(ident, EventKind.GROOVE, 1, 0, 0, amplitude)


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
def test_every_tap_is_commanded_above_the_floor(speed):
    finger, weak = FingerVibration(), Surface(k_tap=1.0, b_tap_per_s=40.0)
    for tick in range(100):
        events = [tap(speed)] if tick == 0 else []
        out = finger.step(tick * DT, ExplorationMode.TAPPING, 0.0, 1.0, surface=weak, events=events)
        assert out >= 1.2 * MOTOR_FLOOR_RPM or tick * DT > TAP_HOLD_S


def test_stroke_is_eq_2_and_gated_by_mode():
    for mode in ExplorationMode:
        out = FingerVibration().step(0.0, mode, -0.06, 1.2, surface=ROUGH)
        assert out == (pytest.approx(rpm(5000 * 0.06 + 120 * 1.2)) if mode is ExplorationMode.STROKING else 0.0)


def test_a_hand_that_stops_ends_its_stroke_however_late_the_mode_follows() -> None:
    finger = FingerVibration()

    def stroke(speed_m_s: float, seconds: float) -> list[float]:
        nonlocal t_s
        shown = []
        for _ in range(round(seconds / DT)):
            t_s += DT
            shown.append(finger.step(t_s, ExplorationMode.STROKING, speed_m_s, 1.5, surface=ROUGH))
        return shown

    t_s = 0.0
    assert min(stroke(0.05, 0.2)) > MOTOR_FLOOR_RPM
    assert min(stroke(0.0, 0.9 * REST_S)) == MOTOR_FLOOR_RPM  # a stroke that reverses
    assert min(stroke(-0.05, 0.2)) > MOTOR_FLOOR_RPM
    assert max(stroke(0.0, 0.5)[round(REST_S / DT) + 1 :]) == 0.0


@pytest.mark.parametrize(
    ("mode", "speed_m_s", "force_n", "more"),
    [
        (ExplorationMode.TAPPING, 0.0, 1.0, {"events": [tap(0.004)], "surface": PVC}),
        (ExplorationMode.QUIESCENT, 0.0, 10.0, {"surface": ROUGH}),
        (ExplorationMode.QUIESCENT, 0.0, 1.0, {"events": [Event(5, EventKind.MATERIAL, 1, 0, 0, 0.99, "pvc")]}),
        (ExplorationMode.FREE, 0.1, 0.0, {"contact_in_s": 0.0, "approach_m_s": 0.2}),
    ],
    ids=["laid down gently", "at rest however hard it presses", "a material's event", "over nothing known"],
)
def test_nothing_vibrates_without_a_sensation(mode, speed_m_s, force_n, more):
    finger, more = FingerVibration(), {"surface": Surface()} | more
    assert all(finger.step(n * DT, mode, speed_m_s, force_n, **more) == 0.0 for n in range(500))


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


@pytest.mark.parametrize("speed_m_s", [0.1, 0.5])
def test_a_tap_that_arrives_after_the_finger_has_left_is_felt(speed_m_s):
    """A network that holds packets for longer than the contact shows only the last of them, in the air again."""
    finger = FingerVibration()
    finger.step(0.0, ExplorationMode.FREE, 0.0, 0.0, surface=PVC)
    late = [
        finger.step(DT * n, ExplorationMode.FREE, 0.0, 0.0, surface=PVC, events=[tap(speed_m_s)] if n == 5 else [])
        for n in range(1, 100)
    ]
    shown = [tick for tick, speed in enumerate(late, start=1) if speed >= 1.2 * MOTOR_FLOOR_RPM]
    assert shown == list(range(5, 5 + len(shown)))
    assert DT * len(shown) == pytest.approx(TAP_HOLD_S, abs=DT)
    assert {speed for speed in late if speed < 1.2 * MOTOR_FLOOR_RPM} == {0.0}


def test_floor_has_hysteresis():
    finger = FingerVibration()
    level = [0.30, 0.40, 0.30, 0.20, 0.30]
    shown = [
        finger.step(i * DT, ExplorationMode.STROKING, share * MOTOR_FLOOR_RPM * RPM_TO_RAD_S / 2000.0, 0.0, surface=PVC)
        for i, share in enumerate(level)
    ]
    assert shown == [0.0, MOTOR_FLOOR_RPM, MOTOR_FLOOR_RPM, 0.0, 0.0]


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
    assert played.new([groove(1.0, 0)]), "forgotten"


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


def coming_down(finger: FingerVibration, contact_s: float, until_s: float, approach_m_s: float = 0.1) -> list[float]:
    """Speeds of a free finger that will meet plastic at `contact_s`."""
    return [
        finger.step(
            n * DT,
            ExplorationMode.FREE,
            0.0,
            0.0,
            surface=PVC,
            contact_in_s=max(0.0, contact_s - n * DT),
            approach_m_s=approach_m_s,
        )
        for n in range(round(until_s / DT))
    ]


def test_a_tap_that_is_known_to_come_starts_the_motor_in_time():
    finger = FingerVibration()
    attack = rpm(PVC.k_tap * 0.1)
    out = coming_down(finger, contact_s=0.2, until_s=0.2)
    rise_s = MOTOR.rise_s(attack * RPM_TO_RAD_S)
    started_s = next(n * DT for n, speed in enumerate(out) if speed > 0.0)
    assert 0.2 - started_s == pytest.approx(rise_s + 0.006, abs=1.5 * DT)
    assert [speed for speed in out if speed > 0.0] == pytest.approx([attack] * sum(speed > 0.0 for speed in out))
    # The contact's own event continues from there, as one tap.
    tapped = finger.step(0.2, ExplorationMode.TAPPING, 0.0, 0.5, surface=PVC, events=[tap(0.1)])
    assert tapped == pytest.approx(attack)
    assert finger.step(0.2 + TAP_S + DT, ExplorationMode.QUIESCENT, 0.0, 0.5, surface=PVC) == 0.0


def test_a_predicted_contact_that_does_not_come_is_given_up():
    finger = FingerVibration()
    out = coming_down(finger, contact_s=0.05, until_s=0.5)
    assert max(out) > 0.0
    assert set(out[round(0.16 / DT) :]) == {0.0}
    # It goes up, and comes down again.
    assert finger.step(0.5, ExplorationMode.FREE, 0.0, 0.0, surface=PVC) == 0.0
    again = finger.step(0.5 + DT, ExplorationMode.FREE, 0.0, 0.0, surface=PVC, contact_in_s=0.001, approach_m_s=0.1)
    assert again > 0.0


def test_matched_intensity_is_linear_in_the_felt_intensity():
    """Twice what Eq. 2 asks for is felt twice as strongly: acceleration grows with the square of the motor's speed."""
    finger, paper = FingerVibration("intensity"), FingerVibration()
    felt = [
        finger.step(n * DT, ExplorationMode.STROKING, speed, 0.0, surface=ROUGH) ** 2
        for n, speed in enumerate((0.05, 0.10, 0.15, 0.20))
    ]
    assert felt == pytest.approx([n * felt[0] for n in (1, 2, 3, 4)])
    # At full speed both agree, and a finger at rest feels nothing in either.
    full = Surface(k_stroke_v=1e5)
    assert finger.step(1.0, ExplorationMode.STROKING, 0.2, 0.0, surface=full) == MOTOR_MAX_RPM
    assert paper.step(1.0, ExplorationMode.STROKING, 0.2, 0.0, surface=full) == MOTOR_MAX_RPM
    assert finger.step(2.0, ExplorationMode.QUIESCENT, 0.0, 9.0, surface=ROUGH) == 0.0


def test_matched_intensity_shows_nothing_that_could_not_be_felt():
    finger, foam = FingerVibration("intensity"), Surface(k_stroke_v=500.0, k_stroke_f=20.0)
    assert finger.step(0.0, ExplorationMode.STROKING, 0.05, 1.0, surface=foam) == 0.0
    assert finger.step(DT, ExplorationMode.STROKING, 0.15, 2.0, surface=foam) >= MOTOR_FLOOR_RPM
