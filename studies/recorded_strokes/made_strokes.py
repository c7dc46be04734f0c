"""Made-up strokes of a slow sensor over grooves, with a finger that sticks and slips.

They share no code with the estimator. Each taxel lies at its own place in the sensor, so that grooves pass one taxel
after the other. The finger's drive oscillates. All taxels then get more and less load at once, and the tip's speed
rises and falls about the nominal speed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SPEEDS_MM_S = (2.0, 5.0, 10.0, 20.0, 30.0)
"""Nominal speeds of the strokes, mm/s."""
RATE_HZ = 35.7
"""Sampling rate of the sensor, 1/s."""
SIZE_MM = (14.0, 10.0)
"""Size of the sensor along and across the stroke, mm."""
TAXELS = 16
"""Number of taxels."""
LOAD_COUNTS = 130.0
"""Mean reading of a taxel."""
ARM_MM = 20.0
"""Wavelength of the arm's swing, mm."""

ARM_SLOPE = 0.6
"""Largest slope of the arm's swing over that of a sine of the pattern's depth.

Of a swing that has more slope and passes the taxels as the grooves do, no stroke can say that it is not the pattern.
"""


@dataclass(frozen=True, slots=True)
class MadeStroke:
    """Conditions of a stroke.

    Attributes:
        speed_mm_s: nominal speed, mm/s.
        period_mm: period of the grooves, mm.
        length_mm: length of the stroke, mm.
        width: width of a groove as a fraction of the period, 0..1; narrow grooves have strong harmonics.
        depth: standard deviation of the pattern as a fraction of the load.
        noise: standard deviation of the noise of a taxel as a fraction of the load.
        arm: amplitude of the arm's swing as a fraction of the load.
        shake: amplitude of the whole sensor's oscillation as a fraction of the load.
        shake_hz: its frequency, 1/s.
        slip: largest change of the tip's speed by this oscillation, as a fraction of the speed; 1 stops the tip.
        lean_mm: standard deviation of the contact's place within the soft sensor, mm.
    """

    speed_mm_s: float
    period_mm: float
    length_mm: float
    width: float
    depth: float
    noise: float
    arm: float
    shake: float
    shake_hz: float
    slip: float
    lean_mm: float


def draw(chance: np.random.Generator, speed_mm_s: float) -> MadeStroke:
    """Draw the conditions of a stroke at this speed, mm/s; half of the strokes stick and slip."""
    finest_mm = max(1.0, 3.0 * speed_mm_s / RATE_HZ)
    period_mm = float(np.exp(chance.uniform(np.log(finest_mm), np.log(20.0))))
    depth = float(np.exp(chance.uniform(np.log(0.01), np.log(0.05))))
    shakes = bool(chance.uniform() < 0.5)
    return MadeStroke(
        speed_mm_s=speed_mm_s,
        period_mm=period_mm,
        length_mm=float(min(150.0, period_mm * chance.uniform(4.0, 60.0))),
        width=float(chance.uniform(0.15, 0.5)),
        depth=depth,
        noise=float(np.exp(chance.uniform(np.log(0.003), np.log(0.02)))),
        arm=min(0.1, ARM_SLOPE * float(chance.uniform()) * 2.0**0.5 * depth * ARM_MM / period_mm),
        shake=float(np.exp(chance.uniform(np.log(0.01), np.log(0.05)))) if shakes else 0.0,
        shake_hz=float(chance.uniform(1.5, 4.0)),
        slip=float(chance.uniform(0.0, 1.0)) if shakes else 0.0,
        lean_mm=float(chance.uniform(0.05, 0.3)),
    )


def make(made: MadeStroke, chance: np.random.Generator) -> tuple[Array, Array]:
    """Return times, s, and readings of all taxels, samples x taxels, whole counts."""
    fine = 8
    n = int(made.length_mm / made.speed_mm_s * RATE_HZ) + 1
    t_s = np.arange(n * fine) / (RATE_HZ * fine)
    swing = _oscillation(t_s, made.shake_hz, chance)
    speed = made.speed_mm_s * (1.0 + made.slip * np.gradient(swing, t_s) / np.abs(np.gradient(swing, t_s)).max())
    tip_mm = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t_s))))
    tip_mm *= made.length_mm / tip_mm[-1]
    tip_mm += made.lean_mm * _slow(tip_mm / made.length_mm, 6, chance)
    along_mm = chance.uniform(0.0, SIZE_MM[0], TAXELS)
    tilt = chance.uniform(0.0, 0.3) * (along_mm / SIZE_MM[0] - 0.5)
    load = LOAD_COUNTS * chance.uniform(0.5, 1.7, TAXELS)
    gain, arm_phase = chance.uniform(0.3, 1.7, TAXELS), chance.uniform(0.0, 2.0 * np.pi)
    readings = np.empty((n, TAXELS))
    for taxel, place_mm in enumerate(along_mm):
        pattern = gain[taxel] * made.depth * _grooves((tip_mm - place_mm) / made.period_mm, made.width)
        arm = made.arm * np.sin(2.0 * np.pi * (tip_mm - place_mm) / ARM_MM + arm_phase)
        shaken = made.shake * (1.0 + tilt[taxel] + 0.1 * chance.normal()) * swing
        drift = 0.02 * _slow(t_s / t_s[-1], 4, chance)
        share = (1.0 + pattern + arm + shaken + drift).reshape(n, fine).mean(axis=1)
        readings[:, taxel] = load[taxel] * (share + made.noise * chance.normal(size=n))
    return t_s[::fine], np.round(readings)


def _grooves(phase: Array, width: float) -> Array:
    """Return the rounded profile of grooves, with a standard deviation of 1."""
    within = np.abs((phase + 0.5) % 1.0 - 0.5)
    grid = np.linspace(0.0, 0.5, 501)
    profile = -1.0 / (1.0 + np.exp((grid - 0.5 * width) / 0.03))
    return np.asarray((np.interp(within, grid, profile) - profile.mean()) / profile.std())


def _slow(share: Array, knots: int, chance: np.random.Generator) -> Array:
    """Return a course through normal values at `knots` places of a stroke, whose places are shares of it, 0..1."""
    return np.asarray(np.interp(share, np.linspace(0.0, 1.0, knots), chance.normal(size=knots)))


def _oscillation(t_s: Array, hz: float, chance: np.random.Generator) -> Array:
    """Return stick and slip: load builds up, drops at once, with cycles of unequal length; amplitude 1."""
    cycles = np.cumsum(np.maximum(1.0 + 0.04 * chance.normal(size=int(t_s[-1] * hz) + 8), 0.5)) / hz
    cycle = np.interp(t_s, np.concatenate(([0.0], cycles)), np.arange(len(cycles) + 1.0)) % 1.0
    return np.asarray(np.where(cycle < 0.7, 2.0 * cycle / 0.7 - 1.0, 1.0 - 2.0 * (cycle - 0.7) / 0.3))
