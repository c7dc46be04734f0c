"""Simulate a finger that explores on command: its true motion, force and mode, and the readings of noisy sensors.

The true mode follows the paper's rule on the noise-free motion. It excludes the arm's shaking, since the hand is
commanded to rest.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_sensors.operator_hand.hand import DRIFT_HZ, DRIFT_M, TREMOR_HZ, TREMOR_XY_M, TREMOR_Z_M
from sim_sensors.physics.fingertip import Fingertip
from sim_sensors.physics.hand_servo import follow
from sim_sensors.physics.remote_world import FORCE_NOISE_N
from sim_sensors.physics.true_mode import TrueMode
from sim_sensors.traces.commanded_hand import TICK_S, Array, CommandedHand, times_s

Modes = NDArray[np.int64]
FORCE_STEP_N = 0.01
"""Resolution of the force in the telemanipulator's frames, N, from 0 up; its noise is that of the simulated world."""
PLACE_STEP_M, PLACE_NOISE_M = 20e-6, 10e-6
"""Resolution of x and y in the telemanipulator's frames, m, and nominal white noise of half a step, m rms."""
HEIGHT_STEP_M, HEIGHT_NOISE_M = 5e-6, 2.5e-6
"""Resolution of the height in the telemanipulator's frames, m, and nominal white noise of half a step, m rms."""
TICK_LATE_S = 0.001
"""Largest usual delay of a tick, s. Devices and loop have separate clocks: a late tick gets a newer reading, and the
next tick may get the same reading again."""
TICK_LOST = 0.002
"""Share of the ticks after which ticks are lost."""
LOST_TICKS = (5, 15)
"""Range of the distance to the next tick where ticks are lost, ticks; the upper end is excluded."""


@dataclass(frozen=True, slots=True)
class Explored:
    """The truth, one value a tick, and each landing: tick of the contact at 0.30 N, approach speed in m/s."""

    time_s: Array
    x_m: Array
    y_m: Array
    z_m: Array
    force_n: Array
    mode: Modes
    landings: tuple[tuple[int, float], ...]


@dataclass(frozen=True, slots=True)
class NoisySample:
    """The readings in the site's loop: time of each of its ticks, sensor values, and their tick in the truth."""

    time_s: Array
    x_m: Array
    y_m: Array
    z_m: Array
    force_n: Array
    tick: NDArray[np.int64]


def explore(hand: CommandedHand, stiffness_n_m: float, rng: np.random.Generator) -> Explored:
    """Let a robot finger follow the commanded hand on an object of this stiffness at height 0."""
    course = hand.course()
    count = len(course["z_m"])
    time_s = times_s(count)
    tremble = [_tremble(time_s, rng) for _ in range(3)]
    along_a, shake_a = rng.uniform(0.0, 2.0 * math.pi, 2)
    set_along = course["along_m"] + TREMOR_XY_M * tremble[0][0] + DRIFT_M * tremble[0][1]
    set_across = TREMOR_XY_M * tremble[1][0] + DRIFT_M * tremble[1][1]
    set_z = course["z_m"] + TREMOR_Z_M * tremble[2][0] + 0.3 * DRIFT_M * tremble[2][1]
    tip, truth = Fingertip(float(set_z[0])), TrueMode()
    along = across = (0.0, 0.0)
    rows, landings = [], []
    for tick in range(count):
        was = truth.contact
        along = follow(TICK_S, *along, float(set_along[tick]))
        across = follow(TICK_S, *across, float(set_across[tick]))
        tip.step(TICK_S, float(set_z[tick]), 0.0, stiffness_n_m)
        slipped = course["slipped_m"][tick] - (course["slipped_m"][tick - 1] if tick else 0.0)
        place = along[0] + course["slipped_m"][tick]
        speed = math.hypot(along[1] + slipped / TICK_S, across[1])
        mode = truth.step(float(time_s[tick]), tip.force_n, place, across[0], speed)
        if truth.contact and not was:
            landings.append((tick, tip.approach_m_s))
        rows.append((place, across[0], tip.z_m, tip.force_n, mode))
    place, across_m, z, force, mode = np.array(rows).T
    x: Array = place * math.cos(along_a) - across_m * math.sin(along_a) + course["shaken_m"] * math.cos(shake_a)
    y: Array = place * math.sin(along_a) + across_m * math.cos(along_a) + course["shaken_m"] * math.sin(shake_a)
    return Explored(time_s, x, y, z, force, mode.astype(np.int64), tuple(landings))


def sense(explored: Explored, noise: float, rng: np.random.Generator) -> NoisySample:
    """Return the site's readings, with late ticks and sensors `noise` (> 0) times as noisy and coarse as nominal."""
    phase, ticks, tick = rng.uniform(), [], 0
    while tick < len(explored.time_s):
        ticks.append(tick)
        tick += int(rng.integers(*LOST_TICKS)) if rng.random() < TICK_LOST else 1
    time_s = explored.time_s[ticks] + phase * TICK_S + rng.uniform(0.0, TICK_LATE_S, len(ticks))
    at = np.minimum(np.searchsorted(explored.time_s, time_s, side="right"), len(explored.time_s)) - 1
    readings, again = np.unique(at, return_inverse=True)

    def measured(true: Array, white_m: float, step_m: float) -> Array:
        steps = (true[at] / noise + white_m * rng.standard_normal(len(readings))[again]) / step_m
        rounded: Array = noise * step_m * np.round(steps)
        return rounded

    force_n = np.maximum(explored.force_n[at] + noise * FORCE_NOISE_N * rng.standard_normal(len(readings))[again], 0.0)
    return NoisySample(
        time_s,
        measured(explored.x_m, PLACE_NOISE_M, PLACE_STEP_M),
        measured(explored.y_m, PLACE_NOISE_M, PLACE_STEP_M),
        measured(explored.z_m, HEIGHT_NOISE_M, HEIGHT_STEP_M),
        FORCE_STEP_N * np.round(force_n / FORCE_STEP_N),
        at,
    )


def _tremble(time_s: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return tremor and drift of a hand, each with amplitude 1."""
    phase = rng.uniform(0.0, 2.0 * math.pi, 2)
    fast, slow = rng.uniform(*TREMOR_HZ), rng.uniform(*DRIFT_HZ)
    return np.sin(2.0 * math.pi * fast * time_s + phase[0]), np.sin(2.0 * math.pi * slow * time_s + phase[1])
