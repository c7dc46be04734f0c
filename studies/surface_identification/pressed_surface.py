"""A fingertip that presses and strokes on something elastic that may move, slope and change: many runs at once.

    m z'' = K (z_set - z) - B z' + F,    F = k(x) d (1 + a d'),    d = s(t, x) - z

The model is that of `sim_sensors/physics/fingertip.py` (after Hunt & Crossley 1975), in steps of 0.1 ms. Sensors read
it every 2 ms.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_sensors.physics.fingertip import MASS_KG, OBJECT_DAMPING_S_M, SERVO_N_M, SERVO_NS_M

Floats = NDArray[np.float64]
Path = Callable[[float], Floats]
"""A quantity of each run at a time, s: (N,)."""

TICK_S = 0.002
_STEP_S = 1e-4
FORCE_NOISE_N, PLACE_NOISE_M = 0.01, 10e-6
STEPS = {"12 bits": (0.0025, 0.0), "CAN frames": (0.01, 5e-6)}
"""Rounding steps of force, N, and height, m; 0: none. The force step of the frames is wider than 12 bits of 10 N."""
HIGHEST_N = 10.23


@dataclass(frozen=True, slots=True)
class Touches:
    """Courses of all runs, (ticks, N) each, every TICK_S from 0 on.

    Attributes:
        force_n, z_m, x_m: contact force and place of the fingertip.
        surface_m, stiffness_n_m: height of the undeformed surface below the finger, and its stiffness.
    """

    force_n: Floats
    z_m: Floats
    x_m: Floats
    surface_m: Floats
    stiffness_n_m: Floats

    @property
    def time_s(self) -> Floats:
        """Times of the ticks, (ticks,), s."""
        return TICK_S * np.arange(len(self.force_n), dtype=np.float64)


def simulate(
    seconds: float,
    setpoint_m: Path,
    stiffness_n_m: Callable[[Floats], Floats],
    *,
    surface_m: Callable[[float, Floats], Floats] = lambda _, x_m: np.zeros_like(x_m),
    x_m: Path | None = None,
    damping_s_m: float | Floats = OBJECT_DAMPING_S_M,
    servo_n_m: float | Floats = SERVO_N_M,
) -> Touches:
    """Simulate all runs.

    Args:
        seconds: duration.
        setpoint_m: wanted heights; the fingers start there.
        stiffness_n_m: of the object, by the fingers' x.
        surface_m: heights of the surface by time, s, and the fingers' x; 0 by default.
        x_m: the fingers' x; 0 by default.
        damping_s_m: Hunt and Crossley's constant.
        servo_n_m: stiffness of the position servo.
    """
    z = setpoint_m(0.0).astype(np.float64)
    v, force = np.zeros((2, len(z)))
    drag = SERVO_NS_M * np.sqrt(servo_n_m / SERVO_N_M)
    decay = 1.0 / (1.0 + _STEP_S * drag / MASS_KG)
    along = x_m or (lambda _: np.zeros(len(z)))
    steps, kept = round(TICK_S / _STEP_S), []
    before = surface_m(0.0, along(0.0))
    for step in range(round(seconds / TICK_S) * steps):
        t_s = step * _STEP_S
        x, target = along(t_s), setpoint_m(t_s)
        surface, stiffness = surface_m(t_s, x), stiffness_n_m(x)
        if step % steps == 0:
            kept.append((force, z, x, surface, stiffness))
        v = (v + _STEP_S / MASS_KG * (servo_n_m * (target - z) + force)) * decay
        z = z + _STEP_S * v
        rise, before = (surface - before) / _STEP_S, surface
        depth = np.maximum(0.0, surface - z)
        force = np.maximum(0.0, stiffness * depth * (1.0 + damping_s_m * (rise - v)))
    return Touches(*(np.array(column) for column in zip(*kept, strict=True)))


def sense(touches: Touches, rng: np.random.Generator, steps: tuple[float, float]) -> tuple[Floats, Floats]:
    """Force, N, and height, m, as the sensors report them: with noise, in steps of `STEPS`."""
    shape = touches.force_n.shape
    force_n = _stepped(touches.force_n + FORCE_NOISE_N * rng.standard_normal(shape), steps[0])
    z_m = _stepped(touches.z_m + PLACE_NOISE_M * rng.standard_normal(shape), steps[1])
    return np.clip(force_n, 0.0, HIGHEST_N), z_m


def minimum_jerk(share: Floats) -> Floats:
    """Share of the way done at a share of a hand movement's time (Flash & Hogan 1985); both 0..1."""
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share**3 * (10.0 - 15.0 * share + 6.0 * share**2))


def _stepped(values: Floats, step: float) -> Floats:
    return np.round(values / step) * step if step else values
