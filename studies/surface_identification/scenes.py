"""Simulates the touches of the study of surface identification: random presses, breathing surfaces, and strokes."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from remote_site.stiffness.surface_estimate import SurfaceEstimate
from sim_sensors.physics.fingertip import OBJECT_DAMPING_S_M, SERVO_N_M
from studies.surface_identification.pressed_surface import TICK_S, Floats, Touches, minimum_jerk, simulate

DEEPEST_M = 0.020
"""Largest travel of a telemanipulator finger into an object, m."""
SERVOS_N_M = (SERVO_N_M, 10_000.0)
"""Stiffness of the position servos, N/m: the telemanipulator's, and a stiff one that follows its set-point."""
SLOWEST_M_S, FASTEST_M_S = 0.01, 0.3
"""Range of the peak speed of a press, m/s."""
LONGEST_S = 2.0
PRESS_FROM_S = 0.3
STROKE_FROM_S = 1.0
STROKE_M_S = 0.03
HAND_STEP_M = 2e-5
"""Resolution of the hand's position in its CAN frame, m."""


class Identified(NamedTuple):
    """Identified surface of one finger, (ticks,) each; 0 without contact."""

    stiffness_n_m: Floats
    surface_m: Floats
    damping_n_s_m: Floats
    slope: Floats
    known: NDArray[np.bool_]


def identify(force_n: Floats, z_m: Floats, x_m: Floats) -> Identified:
    """Identify one finger's surface from sensed force and position, (ticks,) each."""
    surface, rows = SurfaceEstimate(), []
    for tick, (newton, z, x) in enumerate(zip(force_n.tolist(), z_m.tolist(), x_m.tolist(), strict=True)):
        surface.step(TICK_S * tick, newton, x, 0.0, z)
        known = surface.stiffness_n_m, surface.surface_z_m, surface.damping_n_s_m, surface.slope_x
        rows.append((*known, surface.known))
    stiffness, surface_m, damping, slope, known_at = np.array(rows).T
    return Identified(stiffness, surface_m, damping, slope, known_at.astype(bool))


def pressed(
    stiffness_n_m: Floats, rng: np.random.Generator, damping_s_m: float | Floats = OBJECT_DAMPING_S_M
) -> tuple[Touches, Floats]:
    """Press each of N objects once with a minimum-jerk movement: down, hold, up. Return it with the largest forces, N.

    Forces are 2 to 5 N; forces above 2 N are limited to DEEPEST_M of depth. Speeds, hold times, heights and servos are
    drawn at random.
    """
    count = len(stiffness_n_m)
    force_n = np.minimum(rng.uniform(2.0, 5.0, count), np.maximum(2.0, DEEPEST_M * stiffness_n_m))
    above_m, held_s = rng.uniform(0.5e-3, 4e-3, count), rng.uniform(0.05, 0.5, count)
    servo_n_m = rng.choice(SERVOS_N_M, count)
    way_m = above_m + force_n * (1.0 / stiffness_n_m + 1.0 / servo_n_m)
    fastest_m_s = np.exp(rng.uniform(math.log(SLOWEST_M_S), math.log(FASTEST_M_S), count))
    down_s = np.minimum(1.875 * way_m / fastest_m_s, LONGEST_S)  # a minimum-jerk movement at its fastest moment

    def setpoint_m(t_s: float) -> Floats:
        return above_m - way_m * (minimum_jerk(t_s / down_s) - minimum_jerk((t_s - down_s - held_s) / down_s))

    seconds = float((2.0 * down_s + held_s).max()) + 0.1
    touches = simulate(seconds, setpoint_m, lambda _: stiffness_n_m, damping_s_m=damping_s_m, servo_n_m=servo_n_m)
    return touches, force_n


def pressed_again(stiffness_n_m: Floats, rng: np.random.Generator, seconds: float, *, breathes: bool) -> Touches:
    """Press each of N objects again and again without a lift, on a surface that may breathe as a sine.

    Presses have 2 to 4.5 N, or the force at 18 mm of depth if that is less and above 2 N. Between them 0.3 to 1 N
    remain. A motion takes 0.15 to 0.8 s, and the rest after it 0.1 to 1.5 s. A breath moves the surface by 0.3 to
    2.5 mm to each side, 0.2 to 0.5 times a second.
    """
    count = len(stiffness_n_m)
    moves_s, rests_s = rng.uniform(0.15, 0.8, count), rng.uniform(0.1, 1.5, count)
    least_n = rng.uniform(0.3, 1.0, count)
    most_n = np.minimum(rng.uniform(2.0, 4.5, count), np.maximum(2.0, 0.018 * stiffness_n_m))
    amplitude_m = rng.uniform(0.3e-3, 2.5e-3, count) if breathes else np.zeros(count)
    pulse, phase = 2.0 * math.pi * rng.uniform(0.2, 0.5, count), rng.uniform(0.0, 2.0 * math.pi, count)
    way_m = 1.0 / stiffness_n_m + 1.0 / SERVO_N_M

    def setpoint_m(t_s: float) -> Floats:
        again_s = np.maximum(0.0, t_s - PRESS_FROM_S - moves_s - rests_s) % (2.0 * (moves_s + rests_s))
        lifted = minimum_jerk(again_s / moves_s) - minimum_jerk((again_s - moves_s - rests_s) / moves_s)
        level_n = most_n - (most_n - least_n) * lifted
        down = minimum_jerk((t_s - PRESS_FROM_S) / moves_s)
        return 2e-3 - (2e-3 + level_n * way_m) * down

    def surface_m(t_s: float, _: Floats) -> Floats:
        return np.asarray(amplitude_m * (np.sin(pulse * t_s + phase) - np.sin(phase)))

    return simulate(seconds, setpoint_m, lambda _: stiffness_n_m, surface_m=surface_m)


def rested(
    stiffness_n_m: Floats, force_n: float, seconds: float, *, amplitude_m: float = 0.0, frequency_hz: float = 0.0
) -> Touches:
    """Press within 0.4 s and stay, on a surface that may move as a sine."""
    pulse = 2.0 * math.pi * frequency_hz

    def surface_m(t_s: float, x_m: Floats) -> Floats:
        return np.full_like(x_m, amplitude_m * math.sin(pulse * t_s))

    return simulate(seconds, resting(stiffness_n_m, force_n), lambda _: stiffness_n_m, surface_m=surface_m)


def stroked(
    stiffness_n_m: Callable[[Floats], Floats], first_n_m: Floats, force_n: float, seconds: float, slope: float = 0.0
) -> Touches:
    """Press, rest, and stroke along x from STROKE_FROM_S, with a constant set-point of the servo."""
    count = len(first_n_m)
    return simulate(
        seconds,
        resting(first_n_m, force_n),
        stiffness_n_m,
        surface_m=lambda _, x_m: slope * x_m,
        x_m=lambda t_s: np.full(count, STROKE_M_S * max(0.0, t_s - STROKE_FROM_S)),
    )


def resting(stiffness_n_m: Floats, force_n: float) -> Callable[[float], Floats]:
    """Return the set-point of a finger that comes down from 2 mm above a surface at 0 and stays pressed, m."""
    way_m = 2e-3 + force_n * (1.0 / stiffness_n_m + 1.0 / SERVO_N_M)
    return lambda t_s: 2e-3 - way_m * minimum_jerk(np.full(len(way_m), (t_s - PRESS_FROM_S) / 0.4))
