"""The mode machine: allowed transitions from mode to mode."""

import math
from collections.abc import Iterable

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from common.exploration.contact_detector import CONTACT_OFF_N, TAP_S
from common.exploration.exploration_mode import DWELL_S, REST_S, STROKE_DISTANCE_M, STROKE_ON_M_S, ModeDetector
from common.exploration.hand_motion import WINDOW_S, HandMotion
from common.wire.messages import ExplorationMode

FREE, TAPPING, QUIESCENT, STROKING = ExplorationMode
TICK_S = 0.002
UP, DOWN = 0.0, 1.0
Piece = tuple[float, float, float]
"""Seconds, force in N, speed along the bench in m/s."""


class Finger:
    """A finger led over the bench, and the reported modes."""

    def __init__(self) -> None:
        self.hand = HandMotion()
        self.machine = ModeDetector(self.hand)
        self.time_s = self.x_m = 0.0
        self.modes: list[ExplorationMode] = []
        self.taps = 0

    def step(self, force_n: float, x_m: float, z_m: float = 0.0, dt_s: float = TICK_S) -> ExplorationMode:
        self.time_s += dt_s
        self.hand.step(self.time_s, x_m, 0.0)
        self.modes.append(self.machine.step(self.time_s, force_n, z_m))
        self.taps += self.machine.began
        return self.modes[-1]

    def go(self, *pieces: Piece) -> "Finger":
        for seconds, force_n, speed_m_s in pieces:
            for _ in range(round(seconds / TICK_S)):
                self.x_m += speed_m_s * TICK_S
                self.step(force_n, self.x_m)
        return self

    def shake(self, seconds: float, amplitude_m: float, hz: float, speed_m_s: float = 0.0) -> "Finger":
        for tick in range(round(seconds / TICK_S)):
            self.x_m += speed_m_s * TICK_S
            self.step(DOWN, self.x_m + amplitude_m * math.sin(2.0 * math.pi * hz * tick * TICK_S))
        return self

    def order(self) -> list[ExplorationMode]:
        return order(self.modes)


def order(modes: Iterable[ExplorationMode]) -> list[ExplorationMode]:
    reported: list[ExplorationMode] = []
    for mode in modes:
        if not reported or reported[-1] is not mode:
            reported.append(mode)
    return reported


def test_touch_rest_stroke_rest_lift() -> None:
    finger = Finger().go((0.1, UP, 0.0), (0.4, DOWN, 0.0), (0.5, DOWN, 0.05), (0.4, DOWN, 0.0), (0.1, UP, 0.0))
    assert finger.order() == [FREE, TAPPING, QUIESCENT, STROKING, QUIESCENT, FREE]
    assert abs(finger.modes.count(TAPPING) * TICK_S - TAP_S) < 2.0 * TICK_S
    first = finger.modes.index(STROKING) * TICK_S
    assert abs(first - (0.5 + STROKE_DISTANCE_M / 0.05)) < 0.005
    assert abs(finger.modes.count(STROKING) * TICK_S - (1.0 - first + REST_S)) < 0.010


def test_a_turn_is_one_stroke_and_so_is_a_slip() -> None:
    rested, stroke = (0.5, DOWN, 0.0), (0.5, DOWN, 0.05)
    finger = Finger().go(rested, stroke, (0.08, DOWN, 0.0), (0.5, DOWN, -0.05), (0.08, DOWN, 0.0), stroke)
    assert finger.order() == [TAPPING, QUIESCENT, STROKING]
    slipped = Finger().go(rested, (0.1, DOWN, 0.04), rested)
    assert slipped.order() == [TAPPING, QUIESCENT, STROKING, QUIESCENT]
    assert slipped.modes.count(STROKING) * TICK_S < 0.1 + REST_S
    tapped = Finger().go(rested, stroke, (0.06, UP, 0.05), stroke)
    assert tapped.order() == [TAPPING, QUIESCENT, STROKING, FREE, TAPPING, STROKING], "a tap in a stroke is a tap"
    assert tapped.taps == 2


def test_a_stroke_needs_distance_and_speed() -> None:
    rested = (0.5, DOWN, 0.0)
    assert Finger().go(rested, (0.037, DOWN, 0.05)).modes[-1] is QUIESCENT, "fast, not far"
    assert Finger().go(rested, (2.0, DOWN, 0.8 * STROKE_ON_M_S)).order()[-1] is QUIESCENT, "far, not fast"
    assert Finger().go(rested, (2.0, DOWN, 1.2 * STROKE_ON_M_S)).modes[-1] is STROKING


def test_an_arm_that_shakes_strokes_only_where_it_goes_somewhere() -> None:
    landed = Finger().go((0.4, DOWN, 0.0)).shake(1.0, 0.5e-3, 8.0)
    assert landed.order() == [TAPPING, QUIESCENT]
    stroked = Finger().go((0.4, DOWN, 0.0), (0.5, DOWN, 0.05))
    before = len(stroked.modes)
    stroked.shake(1.5, 0.5e-3, 8.0)
    assert order(stroked.modes[before:]) == [STROKING, QUIESCENT]
    assert stroked.modes[before:].count(STROKING) * TICK_S < 0.3
    going_somewhere = Finger().go((0.5, DOWN, 0.0)).shake(2.0, 0.5e-3, 8.0, speed_m_s=0.02)
    assert going_somewhere.order() == [TAPPING, QUIESCENT, STROKING]


def test_a_bounce_is_one_tap() -> None:
    finger = Finger().go((0.1, UP, 0.0), (0.01, DOWN, 0.0), (0.016, UP, 0.0), (0.3, DOWN, 0.0))
    assert finger.order() == [FREE, TAPPING, FREE, TAPPING, QUIESCENT]
    assert finger.taps == 1
    again = Finger().go((0.1, UP, 0.0), (0.01, DOWN, 0.0), (0.06, UP, 0.0), (0.3, DOWN, 0.0))
    assert again.taps == 2, "60 ms are no bounce"


def test_the_approach_is_measured_before_the_impact() -> None:
    for speed_m_s in (0.02, 0.1, 0.3):
        for after_m in (-1e-3, 0.0, 1e-3):
            finger, z_m = Finger(), 0.02
            while z_m > 0.0:
                z_m -= speed_m_s * TICK_S
                finger.step(UP, 0.0, round(z_m / 5e-6) * 5e-6)
            finger.step(0.2, 0.0, z_m + after_m)
            finger.step(0.6, 0.0, z_m + 2.0 * after_m)
            assert finger.machine.began
            assert abs(finger.machine.approach_m_s - speed_m_s) < 0.002


steps = st.lists(
    st.tuples(
        st.floats(-0.5, 1.0) | st.sampled_from((math.nan, math.inf, -math.inf)),
        st.floats(-0.1, 0.1) | st.just(0.0) | st.just(0.05),
        st.integers(1, 30),
    ),
    max_size=60,
)


@given(steps)
def test_every_mode_has_its_reason(pieces: list[tuple[float, float, int]]) -> None:
    finger, machine = Finger(), None
    began_s, tap_x_m, since_s, before = -math.inf, math.nan, 0.0, FREE
    for force_n, speed_m_s, ticks in pieces:
        for _ in range(ticks):
            finger.x_m += speed_m_s * TICK_S
            mode = finger.step(force_n, finger.x_m)
            machine = finger.machine
            assert machine.contact == (mode is not FREE)
            assert not (machine.began and machine.ended)
            if machine.began:
                assert force_n >= CONTACT_OFF_N
                assert mode is TAPPING
                began_s, tap_x_m = finger.time_s, finger.x_m
            assert (mode is TAPPING) == (machine.contact and finger.time_s - began_s < TAP_S)
            if not math.isfinite(force_n):
                assert mode is FREE
            if mode is not before:
                held_s = finger.time_s - since_s + 1e-9
                if mode is STROKING:
                    assert abs(finger.x_m - tap_x_m) > STROKE_DISTANCE_M
                    assert machine.speed_m_s > STROKE_ON_M_S
                    assert before is not QUIESCENT or held_s >= DWELL_S
                if (before, mode) == (STROKING, QUIESCENT):
                    assert held_s >= REST_S - WINDOW_S
                since_s, before = finger.time_s, mode


@given(steps)
def test_a_force_of_nan_counts_as_none(pieces: list[tuple[float, float, int]]) -> None:
    given_, replaced = Finger(), Finger()
    for force_n, speed_m_s, ticks in pieces:
        given_.go((ticks * TICK_S, force_n, speed_m_s))
        replaced.go((ticks * TICK_S, force_n if math.isfinite(force_n) else 0.0, speed_m_s))
    assert given_.modes == replaced.modes


@given(st.integers(0, 2**32 - 1), st.sampled_from((0.0, 0.05)))
def test_noise_makes_no_two_wrong_switches(seed: int, speed_m_s: float) -> None:
    draw, finger = np.random.default_rng(seed), Finger()
    for tick in range(600):
        force_n = (UP if tick < 100 else DOWN) + 0.03 * draw.standard_normal()
        x_m = speed_m_s * TICK_S * max(0, tick - 300) + 30e-6 * draw.standard_normal()
        finger.step(max(force_n, 0.0), round(x_m / 60e-6) * 60e-6)
    assert finger.order() == [FREE, TAPPING, QUIESCENT, STROKING][: 4 if speed_m_s else 3]


def test_a_clock_set_back_restarts_the_estimates() -> None:
    finger = Finger().go((0.5, DOWN, 0.0), (0.3, DOWN, 0.05))
    finger.time_s = 0.1
    finger.go((0.02, UP, 0.0), (0.3, DOWN, 0.0))
    assert finger.modes[-1] is QUIESCENT
