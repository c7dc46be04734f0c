"""Fits the law of a texture sensor to labelled strokes: noise, viscosity, and exponents of force and speed.

With the right viscosity, a fast stroke over a surface is as rough as a slow one. The search for it keeps the speed
exponent fixed; a regression then finds the exponents. If both were free, a long lag and a power of the speed would
compensate each other on one surface and be wrong on the next.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.wire.messages import ExplorationMode
from remote_site.texture.recorded.stroke_playback import EvenStroke, felt
from remote_site.texture.surface_table import Surface, SurfaceTable
from remote_site.texture.texture_identification import BLOCK
from remote_site.texture.texture_law import NOMINAL_FORCE_N, NOMINAL_SPEED_M_S, TextureLaw, ln_roughness
from remote_site.texture.tip_path import SLOWEST_M_S

Array = NDArray[np.float64]
LEAST_SPREAD = 0.2
"""Minimum standard deviation of ln(force) or ln(speed) within surfaces for which its exponent is fitted."""
VISCOUS_S = (0.0, 0.5e-3, 1e-3, 1.5e-3, 2e-3, 4e-3)
"""Time constants tried before the best is refined, s."""
_STEP = 2
"""Step of the second difference that measures the noise at rest, samples: 1 ms, in which nothing else moves."""
_LEAST_REST = 100
"""Minimum number of second differences at rest."""
_ANYTHING = [Surface(name="anything", ln_roughness=-5.0, ln_roughness_sd=1.0, k_stroke_v=1.0, k_stroke_f=1.0)]


@dataclass(frozen=True, slots=True)
class LabelledStroke:
    """A stroke over a known surface.

    Attributes:
        file: name of its source.
        surface: label.
        stroke: the stroke at the sensor's rate.
        roughness_um: roughness of the surface, um; None where it is unknown.
        assumed: names of the quantities that are nominal because they were not recorded.
    """

    file: str
    surface: str
    stroke: EvenStroke
    roughness_um: float | None = None
    assumed: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LawFit:
    """A fitted law, with the parts that could be fitted; the other parts have usual values."""

    law: TextureLaw
    noise_known: bool
    force_known: bool
    speed_known: bool
    left_ln: float
    """Standard deviation of ln(roughness) within surfaces that the law leaves."""


def fit_law(strokes: Sequence[LabelledStroke]) -> LawFit:
    """Fit the law to strokes over two or more surfaces, or over one surface at several forces and speeds.

    Raises:
        ValueError: a stroke never moves.
    """
    noise_v = sensor_noise_v([labelled.stroke for labelled in strokes])
    usual = TextureLaw() if noise_v is None else TextureLaw(noise_v=noise_v)
    names = [labelled.surface for labelled in strokes]
    x = _within(_ways_of_moving(strokes), names)
    force_known, speed_known = bool(x[:, 0].std() > LEAST_SPREAD), bool(x[:, 1].std() > LEAST_SPREAD)

    def regress(viscous_s: float, speed_free: bool) -> tuple[float, Array]:
        law = usual.model_copy(update={"viscous_s": viscous_s, "force_exponent": 0.0, "speed_exponent": 0.0})
        y = _within(np.array([[mean_ln_roughness(labelled.stroke, law)] for labelled in strokes]), names)[:, 0]
        exponents = np.array([usual.force_exponent, usual.speed_exponent])
        free = np.array([force_known, speed_known and speed_free])
        if free.any():
            rest = y - x[:, ~free] @ exponents[~free]
            exponents[free] = np.linalg.lstsq(x[:, free], rest, rcond=None)[0]
        exponents = np.clip(exponents, (0.0, -2.0), 2.0)
        return float(np.std(y - x @ exponents)), exponents

    viscous_s = usual.viscous_s
    if speed_known:
        left = np.array([regress(tau, False)[0] for tau in VISCOUS_S])
        best = int(left.argmin())
        viscous_s = VISCOUS_S[best]
        if 0 < best < len(VISCOUS_S) - 1:
            square, slope, _ = np.polyfit(VISCOUS_S[best - 1 : best + 2], left[best - 1 : best + 2], 2)
            viscous_s = float(-0.5 * slope / square)
    left_ln, (force, speed) = regress(viscous_s, True)
    law = usual.model_copy(
        update={"viscous_s": viscous_s, "force_exponent": float(force), "speed_exponent": float(speed)}
    )
    return LawFit(law, noise_v is not None, force_known, speed_known, left_ln)


def sensor_noise_v(strokes: Sequence[EvenStroke]) -> float | None:
    """Return the rms noise of a sample while the finger rests on a surface, V, from the quietest strokes.

    The result is None if no finger rests.
    """
    found = []
    for stroke in strokes:
        resting = np.array([block.mode is ExplorationMode.QUIESCENT for block in felt(stroke, anything(TextureLaw()))])
        samples = len(stroke.time_s)
        rest = np.zeros(samples, dtype=bool)
        rest[: BLOCK * len(resting)] = np.repeat(resting, BLOCK)
        rest &= stroke.speed_m_s < SLOWEST_M_S
        whole = rest[: -2 * _STEP] & rest[_STEP:-_STEP] & rest[2 * _STEP :]
        v = stroke.signal_v
        bend_v = (v[: -2 * _STEP] - 2.0 * v[_STEP:-_STEP] + v[2 * _STEP :])[whole]
        if len(bend_v) >= _LEAST_REST:
            # the mean magnitude, since a median would be one of the converter's few steps
            found.append(math.sqrt(0.5 * math.pi / 6.0) * float(np.abs(bend_v).mean()))
    return float(np.quantile(found, 0.25)) if found else None


def mean_ln_roughness(stroke: EvenStroke, law: TextureLaw) -> float:
    """Return ln(roughness in V) of a whole stroke without its first third and without grooves."""
    stroking = [b.texture for b in felt(stroke, anything(law)) if b.mode is ExplorationMode.STROKING]
    settled = [texture.roughness_v for texture in stroking[len(stroking) // 3 :] if texture.valid]
    return ln_roughness(float(np.sqrt(np.mean(np.square(settled)))) if settled else 0.0)


def anything(law: TextureLaw) -> SurfaceTable:
    """Return a table with the law of a sensor and one surface for anything."""
    return SurfaceTable(law=law, surfaces=_ANYTHING)


def _ways_of_moving(strokes: Sequence[LabelledStroke]) -> Array:
    """Return ln(force) and ln(speed) of every stroke while it moves, shape (strokes, 2)."""
    rows = []
    for labelled in strokes:
        stroke = labelled.stroke
        moving = stroke.speed_m_s > 0.5 * float(np.quantile(stroke.speed_m_s, 0.9))
        if not moving.any():
            raise ValueError(f"{labelled.file}: column speed_mm_s: the finger never moves; leave this stroke out")
        rows.append(
            (
                np.log(max(float(stroke.force_n[moving].mean()), 1e-3) / NOMINAL_FORCE_N),
                np.log(max(float(stroke.speed_m_s[moving].mean()), 1e-4) / NOMINAL_SPEED_M_S),
            )
        )
    return np.array(rows)


def _within(values: Array, names: Sequence[str]) -> Array:
    """Subtract from each value the mean of its surface, by column."""
    label = np.array(names)
    means = {name: values[label == name].mean(axis=0) for name in set(names)}
    centred: Array = values - np.array([means[name] for name in names])
    return centred
