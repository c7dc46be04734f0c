"""Hands that explore at random: taps, rests, strokes with turns, and motions that confuse mode detection."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from sim_sensors.physics.fingertip import SERVO_N_M, pressing_depth_m
from sim_sensors.traces.commanded_hand import UP_M, CommandedHand
from sim_sensors.traces.simulated_exploration import Explored, explore

STIFFNESS_N_M = (400.0, 6000.0)
"""Range of the object's stiffness, N/m: from foam to stiffer than PVC."""
APPROACH_M_S = (0.02, 0.3)
"""Range of the peak speed on the way down, m/s. The finger lands at another speed, which is the true one of a tap."""
PRESS_N, GRAZE_N, BARELY_N = (0.6, 3.0), (0.33, 0.45), (0.20, 0.30)
STROKE_M_S, STROKE_M = (0.02, 0.15), (0.015, 0.08)
TURN_S = 0.2
"""Time of a reversal without a stop, s."""
SLIP_M, SLIP_S = (0.0025, 0.006), (0.06, 0.15)
SHAKE_M, SHAKE_HZ = (0.2e-3, 0.5e-3), (6.0, 12.0)
"""Amplitude, m, and frequency, Hz, of shaking along the bench. Vertical shaking would change the force and could truly
end contact."""


class _Hand:
    """A commanded hand over one object."""

    def __init__(self, draw: np.random.Generator) -> None:
        self.commanded, self.draw = CommandedHand(), draw
        self.stiffness_n_m = math.exp(draw.uniform(*np.log(STIFFNESS_N_M)))
        self.speed_m_s = math.exp(draw.uniform(*np.log(STROKE_M_S)))

    def land(self, force_n: float | None = None) -> None:
        """Come down with the peak speed near the surface, and press."""
        force = self.draw.uniform(*PRESS_N) if force_n is None else force_n
        approach = math.exp(self.draw.uniform(*np.log(APPROACH_M_S)))
        depth = pressing_depth_m(force, self.stiffness_n_m)
        self.commanded.height(-depth, 1.875 * (UP_M + depth) / approach)

    def lift(self) -> None:
        self.commanded.height(UP_M, self.draw.uniform(0.12, 0.3))
        self.commanded.stay(self.draw.uniform(0.05, 0.4))

    def rest(self, least_s: float = 0.3, most_s: float = 1.5) -> None:
        self.commanded.stay(self.draw.uniform(least_s, most_s))

    def distance_m(self) -> float:
        return float(self.draw.uniform(*STROKE_M) * self.draw.choice((-1.0, 1.0)))


def _taps(hand: _Hand) -> None:
    for _ in range(hand.draw.integers(1, 5)):
        hand.land()
        hand.rest(0.02, 0.2)
        hand.lift()


def _touch(hand: _Hand) -> None:
    hand.land()
    hand.rest(0.4, 2.0)
    hand.lift()


def _strokes(hand: _Hand) -> None:
    """Stroke to and fro; in between come a rest, an instantaneous stop, or a turn."""
    hand.land()
    hand.rest()
    speed = hand.speed_m_s
    for _ in range(hand.draw.integers(1, 4)):
        hand.commanded.stroke(hand.distance_m(), speed)
        if hand.draw.random() < 0.5:
            hand.rest()
        way = hand.distance_m()
        hand.commanded.change_speed(0.0, math.copysign(speed, way))
        for _ in range(hand.draw.integers(1, 4)):
            hand.commanded.go(math.copysign(speed, way), abs(way) / speed)
            hand.commanded.change_speed(math.copysign(speed, way), -math.copysign(speed, way), TURN_S)
            way = -way
        hand.commanded.go(math.copysign(speed, way), 0.5 * abs(way) / speed)
        hand.commanded.change_speed(math.copysign(speed, way), 0.0)
        hand.rest()
    hand.lift()


def _tap_in_stroke(hand: _Hand) -> None:
    """The finger lifts for about 60 ms while the hand moves on."""
    hand.land()
    hand.rest()
    down, speed = hand.commanded.z_m, hand.speed_m_s
    hand.commanded.change_speed(0.0, speed)
    for _ in range(hand.draw.integers(1, 3)):
        hand.commanded.go(speed, hand.draw.uniform(0.3, 0.8))
        hand.commanded.height(0.0015, 0.06, along_speed_m_s=speed)
        hand.commanded.go(speed, hand.draw.uniform(0.01, 0.04))
        hand.commanded.height(down, 0.06, along_speed_m_s=speed)
        hand.commanded.go(speed, hand.draw.uniform(0.4, 0.8))
    hand.commanded.change_speed(speed, 0.0)
    hand.rest()
    hand.lift()


def _slip(hand: _Hand) -> None:
    """A held object slips a few millimetres at once."""
    hand.land()
    for _ in range(hand.draw.integers(1, 3)):
        hand.rest()
        hand.commanded.slip(hand.draw.uniform(*SLIP_M), hand.draw.uniform(*SLIP_S))
    hand.rest()
    hand.lift()


def _graze(hand: _Hand, force_n: tuple[float, float] = GRAZE_N) -> None:
    """Touch so lightly that the force barely passes the threshold and falls below it again, at rest or in motion."""
    hand.land(hand.draw.uniform(*force_n))
    sway = hand.draw.uniform(0.02, 0.10) * (1.0 / SERVO_N_M + 1.0 / hand.stiffness_n_m)
    hz = hand.draw.uniform(0.5, 2.0)
    hand.commanded.sway(sway, hz, hand.draw.uniform(0.5, 1.5))
    hand.commanded.change_speed(0.0, hand.speed_m_s)
    hand.commanded.sway(sway, hz, hand.draw.uniform(0.5, 1.5), along_speed_m_s=hand.speed_m_s)
    hand.commanded.change_speed(hand.speed_m_s, 0.0)
    hand.rest()
    hand.lift()


def _shake(hand: _Hand) -> None:
    """The arm shakes while the hand rests: after landing, and after a stroke."""
    hand.land()
    amplitude, hz = hand.draw.uniform(*SHAKE_M), hand.draw.uniform(*SHAKE_HZ)
    hand.rest(0.2, 0.5)
    hand.commanded.shake(amplitude, hz, hand.draw.uniform(0.5, 1.5))
    hand.commanded.stroke(hand.distance_m(), hand.speed_m_s)
    hand.commanded.shake(amplitude, hz, hand.draw.uniform(0.8, 2.0))
    hand.lift()


SCENES: dict[str, Callable[[_Hand], None]] = {
    "taps": _taps,
    "touch": _touch,
    "strokes": _strokes,
    "tap in stroke": _tap_in_stroke,
    "slip": _slip,
    "graze": _graze,
    "shaking arm": _shake,
}


BARELY = "barely touching"
"""Scene whose forces stay below the threshold of contact, within the noise; no method can detect such contact."""
_ALL: dict[str, Callable[[_Hand], None]] = SCENES | {BARELY: partial(_graze, force_n=BARELY_N)}


def scene(kind: str, seed: int) -> Explored:
    """Explore one kind of scene with one hand; the seed determines everything random."""
    draw = np.random.default_rng([seed, list(_ALL).index(kind)])
    hand = _Hand(draw)
    hand.commanded.stay(0.3)
    _ALL[kind](hand)
    return explore(hand.commanded, hand.stiffness_n_m, draw)
