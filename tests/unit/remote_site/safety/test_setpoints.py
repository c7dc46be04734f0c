"""Set-points at their bounds, the limits that act on them, and the slow approach after a release."""

import math

import pytest

from common.buses.can_frames import FrameReceiver, FrameSender
from common.limits import APPROACH_DOWN_M_S, CONTACT_FORCE_N, LEFT_J
from remote_site.safety.limit_flags import APPROACH, ENERGY, FORCE, HEIGHT_RANGE, HEIGHT_SPEED
from remote_site.safety.servo import SERVO_N_M
from remote_site.safety.setpoints import (
    BRAKE_SHARE,
    CLEAR_HEIGHT_M,
    HEIGHT_HIGH_M,
    HEIGHT_LOW_M,
    HEIGHT_SPEED_M_S,
    MET_M,
    REACTION_S,
    RETREAT_M_S,
    ROUNDING_M,
    STOP_S,
    TOUCHING_N,
    WIDEN_M_S2,
    ApproachLimiter,
    HeightSetpoint,
)

DT, TOP_M = 0.002, HEIGHT_HIGH_M
BRAKE_N = BRAKE_SHARE * CONTACT_FORCE_N
OVER_N = math.nextafter(CONTACT_FORCE_N, 9.0)
UP_M, DOWN_M = HEIGHT_SPEED_M_S * DT, APPROACH_DOWN_M_S * DT
BRAKED_N = BRAKE_N - 0.5 * APPROACH_DOWN_M_S * SERVO_N_M * REACTION_S
"""At this force a finger goes down at half the approach speed."""


def finger_at(z_m: float, left_j: float = 0.0) -> HeightSetpoint:
    """A finger let go at a height, with the work, J, that it has left in what it touches."""
    finger = HeightSetpoint(CONTACT_FORCE_N)
    finger.let_go(z_m)
    finger.observe(0.0, 0.0, 0.0, 1.0, False)
    finger.observe(0.0, 0.0, -left_j, 1.0, False)
    return finger


def test_a_set_point_begins_clear_and_within_the_range_of_the_frames() -> None:
    finger = HeightSetpoint(CONTACT_FORCE_N)
    assert finger.z_m == CLEAR_HEIGHT_M
    for z_m, begins_m in ((-1.0, HEIGHT_LOW_M), (0.001, 0.001), (1.0, HEIGHT_HIGH_M)):
        finger.let_go(z_m)
        assert finger.z_m == begins_m


def test_frames_hold_every_set_point() -> None:
    """A clipped one would move while the finger does not, as if its encoder were stuck."""
    heights_mm = (1e3 * HEIGHT_HIGH_M, 1e3 * HEIGHT_LOW_M, 0.0, 0.0, 0.0, 0.0)
    sent = FrameReceiver("HeightSetpoint").values(FrameSender("HeightSetpoint").next_frame(heights_mm)[1])
    assert sent == pytest.approx(heights_mm, abs=1e-9)


@pytest.mark.parametrize(
    ("pressed_n", "stopped_s", "rises"),
    [
        (0.0, math.nextafter(STOP_S, 0.0), False),
        (0.0, STOP_S, True),
        (CONTACT_FORCE_N, 0.0, False),
        (OVER_N, 0.0, True),
        (math.nan, 0.0, False),
    ],
)
def test_a_set_point_retreats_after_a_stop_or_a_hard_press(pressed_n: float, stopped_s: float, rises: bool) -> None:
    finger = finger_at(0.0)
    finger.retreat(DT, pressed_n, stopped_s)
    assert finger.z_m == (RETREAT_M_S * DT if rises else 0.0)


@pytest.mark.parametrize(
    ("begins_m", "wanted_m", "measured_m", "pressed_n", "hand_met", "left_j", "expected_m", "limits"),
    [
        pytest.param(0.0, 0.0, 0.0, 0.0, True, 0.0, 0.0, 0, id="where it is wanted"),
        pytest.param(0.0, 0.0, 0.0, 0.0, False, 0.0, 0.0, APPROACH, id="where it is wanted, hand not there"),
        pytest.param(0.0, -ROUNDING_M, 0.0, BRAKE_N, True, 0.0, 0.0, 0, id="rounding when braked"),
        pytest.param(0.0, -2e-9, 0.0, BRAKE_N, True, 0.0, 0.0, FORCE, id="more than rounding when braked"),
        pytest.param(0.0, -0.01, 0.0, 0.0, True, 0.0, -DOWN_M, APPROACH | HEIGHT_SPEED, id="down"),
        pytest.param(0.0, 0.01, 0.0, 0.0, False, 0.0, UP_M, APPROACH | HEIGHT_SPEED, id="up"),
        pytest.param(0.0, -0.01, 0.0, 0.0, False, 0.0, 0.0, APPROACH | HEIGHT_SPEED, id="hand not there"),
        pytest.param(0.0, -0.01, 0.0, BRAKE_N, False, 0.0, 0.0, APPROACH | HEIGHT_SPEED, id="braked, hand not there"),
        pytest.param(0.0, -0.01, 0.0, BRAKED_N, True, 0.0, -0.5 * DOWN_M, APPROACH | FORCE, id="slowed by force"),
        pytest.param(0.0, -0.01, 0.0, BRAKE_N, True, 0.0, 0.0, APPROACH | FORCE, id="braked"),
        pytest.param(0.0, -0.01, 0.0, BRAKE_N, True, LEFT_J, 0.0, APPROACH | FORCE, id="braked, no room for work"),
        pytest.param(0.0, -0.01, 0.0, 1.0, True, LEFT_J, 0.0, APPROACH | ENERGY, id="no room for work"),
        pytest.param(0.0, -0.01, 0.0, 0.0, True, LEFT_J, 0.0, APPROACH | ENERGY, id="no room for work in the air"),
        pytest.param(
            0.0,
            -1.0,
            0.0,
            1.0,
            True,
            LEFT_J,
            0.0,
            APPROACH | ENERGY | HEIGHT_RANGE,
            id="no room for work, too low",
        ),
        pytest.param(0.0, -1.0, 0.0, 0.0, True, 0.0, -DOWN_M, APPROACH | HEIGHT_SPEED | HEIGHT_RANGE, id="too low"),
        pytest.param(0.0, 1.0, 0.0, 0.0, True, 0.0, UP_M, APPROACH | HEIGHT_SPEED | HEIGHT_RANGE, id="too high"),
        pytest.param(TOP_M, 1.0, 0.0, 0.0, True, 0.0, TOP_M, HEIGHT_RANGE, id="at the top"),
        pytest.param(HEIGHT_LOW_M, HEIGHT_LOW_M, HEIGHT_LOW_M, 0.0, True, 0.0, HEIGHT_LOW_M, 0, id="at the bottom"),
        pytest.param(0.0, 1.0, 0.0, OVER_N, True, 0.0, UP_M, FORCE | HEIGHT_RANGE, id="presses too hard, too high"),
        pytest.param(0.0, 0.0, 0.0, CONTACT_FORCE_N, True, 0.0, 0.0, 0, id="presses as hard as it may"),
        pytest.param(0.0, 0.0, CONTACT_FORCE_N / SERVO_N_M, 0.0, True, 0.0, 0.0, 0, id="as deep as it may"),
        pytest.param(0.0, 0.0, 0.0051, 0.0, True, 0.0, 0.0051 - 0.005, FORCE, id="too deep"),
        pytest.param(0.0, -0.01, 0.01, 0.0, True, 0.0, UP_M, APPROACH | HEIGHT_SPEED | FORCE, id="far too deep"),
        pytest.param(
            HEIGHT_HIGH_M, 0.0, 1.0, 0.0, False, 0.0, HEIGHT_HIGH_M, APPROACH | HEIGHT_SPEED | FORCE, id="top"
        ),
    ],
)
def test_each_acting_limit_is_named(
    begins_m: float,
    wanted_m: float,
    measured_m: float,
    pressed_n: float,
    hand_met: bool,
    left_j: float,
    expected_m: float,
    limits: int,
) -> None:
    finger = finger_at(begins_m, left_j)
    assert finger.follow(DT, wanted_m, measured_m, pressed_n, hand_met) == limits
    assert finger.z_m == pytest.approx(expected_m, abs=1e-12)


@pytest.mark.parametrize(("missed_m", "limits"), [(ROUNDING_M, 0), (2.0 * ROUNDING_M, HEIGHT_SPEED)])
def test_a_set_point_that_misses_by_rounding_only_is_not_limited(missed_m: float, limits: int) -> None:
    for wanted_m in (-missed_m, missed_m):
        assert finger_at(0.0).follow(0.0, wanted_m, 0.0, 0.0, True) == limits


@pytest.mark.parametrize("pressed_n", [0.0, TOUCHING_N, 1.0])
def test_the_room_for_work_limits_the_speed_downwards(pressed_n: float) -> None:
    room_j = 0.5 * APPROACH_DOWN_M_S * REACTION_S * max(TOUCHING_N, pressed_n)
    finger = finger_at(0.0, LEFT_J - room_j)
    assert finger.follow(DT, -0.01, 0.0, pressed_n, True) == APPROACH | ENERGY
    assert finger.z_m == pytest.approx(-0.5 * DOWN_M)


def test_the_approach_is_slow_until_it_has_met_and_then_reaches_full_speed() -> None:
    approach = ApproachLimiter(0.1, 0.1 + 1.5 * WIDEN_M_S2)

    def state() -> tuple[float, bool, bool]:
        return approach.limit_m_s, approach.met, approach.settled

    for _ in range(2):
        assert state() == (0.1, False, False)
        approach.step(1.0, math.nextafter(MET_M, 1.0))
        assert state() == (0.1, False, False)
        approach.step(1.0, MET_M)
        assert state() == (pytest.approx(0.1 + WIDEN_M_S2), True, False)
        approach.step(1.0, 1.0)  # it has met: how far it stays behind no longer counts
        assert state() == (0.1 + 1.5 * WIDEN_M_S2, True, True)
        approach.let_go()
