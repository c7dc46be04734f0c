"""Identifies the texture under one finger: roughness, grooves and surface, from samples, force, speed and mode.

This module joins the estimators. It processes samples in blocks of BLOCK, so that the answer does not depend on the
number of samples that arrive at once.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from common.wire.messages import ExplorationMode
from remote_site.texture.curvature_noise import CurvatureNoise
from remote_site.texture.groove_detector import GrooveDetector, Impulse
from remote_site.texture.roughness import PathCell, Roughness
from remote_site.texture.sensor_fault import RAIL_V, SensorFault
from remote_site.texture.surface_filter import SurfaceFilter
from remote_site.texture.surface_table import GROOVE_RAD_S, Surface, SurfaceTable
from remote_site.texture.texture_law import ln_roughness
from remote_site.texture.tip_path import CELL_M, RATE_HZ, Curve, TipPath

_Value = TypeVar("_Value")
_Sample = tuple[float, float, float, ExplorationMode]
"""Signal, V, contact force, N, speed, m/s, and mode."""
BLOCK = 10
"""Number of samples in a block."""
FAINTEST_GROOVE_V = 0.010
"""Minimum curvature of a groove for one newton if none was calibrated, V; it equals a depth of 1 um."""
FAINTEST, STRONGEST = 0.25, 1.5
"""Range of an impulse's amplitude over GROOVE_RAD_S; within it, the amplitude follows the groove's strength."""
LISTEN_M = 1e-3
"""Length of path between updates of the surface filter, m."""
BEHIND_M = 0.6e-3
"""Maximum distance behind the tip at which a groove is found, m; the path is free of grooves up to there."""
SETTLE_M = 15e-3
"""Length of path within which changes of roughness and of the recognised surface count as one change, m.

A contact needs the same length to establish its first surface.
"""
DIFFERENT = 0.25
"""Minimum difference in ln(roughness) for a change between two surfaces without grooves."""
CARRY_S = 0.3
"""Maximum loss of contact that keeps the recognised surface, s; a softer object may cause a short one."""
_LISTEN = round(LISTEN_M / CELL_M)
STROKING_M_S = 10e-3
"""Speed below which the surface hardly moves the signal, m/s."""
_GAP_S = 3.0 * BLOCK / RATE_HZ
"""Maximum time between the ends of two blocks of one path, s."""


@dataclass(frozen=True, slots=True)
class TextureReading:
    """Present estimate of the texture, and the events in the newest samples.

    Attributes:
        roughness_v: rms curvature for one newton without grooves and noise, V.
        valid: whether `roughness_v` describes the surface being touched.
        surface: name of the recognised surface; None while no surface is sure.
        best: name of the likeliest surface.
        probability: probability of the likeliest surface, 0..1.
        impulses: grooves and edges found in these samples, oldest first.
        fault: fault of the sensor, None without one; a fault suspends the identification.
        changed_s: time at which these samples showed a change of surface, s; None without a change.
    """

    roughness_v: float
    valid: bool
    surface: str | None
    best: str
    probability: float
    impulses: tuple[Impulse, ...]
    changed_s: float | None
    fault: str | None = None


class TextureIdentification:
    """Texture identification of one finger.

    Attributes:
        interrupted: whether the samples of the last `take` interrupted the path.
    """

    def __init__(self, surfaces: SurfaceTable, rail_v: float = RAIL_V) -> None:
        """Identify with the law of the sensor and the calibrated surfaces; `rail_v` is the end of its range, V."""
        self._law = surfaces.law
        self._noise = CurvatureNoise(self._law.viscous_s)
        self._path = TipPath(self._law.viscous_s, self._law.leak_hz)
        faintest_v = FAINTEST_GROOVE_V if surfaces.groove_v is None else 0.2 * FAINTEST * surfaces.groove_v
        self._impulses = GrooveDetector(faintest_v)
        self._roughness = Roughness()
        self._filter = SurfaceFilter(surfaces)
        self._watch = SensorFault(BLOCK, rail_v, self._law.noise_v)
        self._waiting: list[_Sample] = []
        self._mode = ExplorationMode.FREE
        self._lost_s = -math.inf
        self._time_s = -np.inf
        self.interrupted = False
        self._forget()

    def _forget(self) -> None:
        """Forget the surface after a loss of contact."""
        self._path.forget()
        self._impulses.forget()
        self._roughness.forget()
        self._filter.forget()
        self._surface: Surface | None = None
        self._ln_roughness = 0.0
        self._changed_m = 0.0
        self.interrupt()

    def _lose(self, t_s: float) -> None:
        """Lose contact but keep the surface for comparison: the finger may jump to another surface."""
        surface = self._surface
        self._forget()
        if surface is not None:
            self._surface, self._changed_m = surface, -math.inf
        self._lost_s = t_s

    def interrupt(self) -> None:
        """Interrupt the path: the distance to the next groove is unknown, and no curvature spans the interruption."""
        self._path.interrupt()
        self._impulses.interrupt()
        self._roughness.interrupt()
        self._filter.interrupt()
        self._moved_m: float | None = None
        self._settled: list[PathCell] = []
        self.interrupted = True

    @property
    def fault(self) -> str | None:
        """Fault of the sensor; None without a fault."""
        return self._watch.fault

    @property
    def valid(self) -> bool:
        """Whether `roughness_v` describes the surface being touched."""
        return self._roughness.valid and self.fault is None

    @property
    def roughness_v(self) -> float:
        """Rms curvature for one newton without grooves and noise, V; 0 during a fault."""
        return self._roughness.roughness_v if self.fault is None else 0.0

    @property
    def roughness_sd_v(self) -> float:
        """Standard deviation of the roughness, V."""
        return self._roughness.roughness_sd_v

    def step(
        self,
        t_s: float,
        signal_v: ArrayLike,
        force_n: float | Sequence[float],
        speed_m_s: float | Sequence[float],
        mode: ExplorationMode | Sequence[ExplorationMode],
    ) -> TextureReading:
        """Take consecutive samples at 2 kHz, the last at `t_s`.

        Args:
            t_s: time, s.
            signal_v: samples, V.
            force_n: contact force, N; one value for each sample, or one for all.
            speed_m_s: stroke speed, m/s, >= 0; one value for each sample, or one for all.
            mode: exploration mode; one for each sample, or one for all.
        """
        samples_v = np.atleast_1d(np.asarray(signal_v, dtype=float)).tolist()
        count = len(samples_v)
        columns = samples_v, _each(force_n, count), _each(speed_m_s, count), _each(mode, count)
        impulses, changed_s = self._gather(t_s, list(zip(*columns, strict=True)))
        sure = self._filter.sure
        return TextureReading(
            self.roughness_v,
            self.valid,
            None if sure is None else sure.name,
            self._filter.best.name,
            float(self._filter.probabilities.max()),
            tuple(impulses),
            changed_s,
            self.fault,
        )

    def take(
        self, t_s: float, samples_v: Sequence[float], force_n: float, speed_m_s: float, mode: ExplorationMode
    ) -> list[Impulse]:
        """Take samples as `step`, with one force, speed and mode for all; return only their impulses."""
        self.interrupted = False
        if len(samples_v) == BLOCK and not self._waiting:
            return self._block(t_s, samples_v, force_n, speed_m_s, mode)[0]
        return self._gather(t_s, [(sample_v, force_n, speed_m_s, mode) for sample_v in samples_v])[0]

    def _gather(self, t_s: float, samples: list[_Sample]) -> tuple[list[Impulse], float | None]:
        """Process each block that these samples complete; return impulses, and the time of a change of surface, s."""
        impulses: list[Impulse] = []
        changed_s = None
        left = len(samples)
        for sample in samples:
            left -= 1
            self._waiting.append(sample)
            if len(self._waiting) == BLOCK:
                block_v, block_n, block_m_s, block_modes = zip(*self._waiting, strict=True)
                self._waiting = []
                found, changed = self._block(
                    t_s - left / RATE_HZ, block_v, sum(block_n) / BLOCK, sum(block_m_s) / BLOCK, block_modes[-1]
                )
                impulses += found
                changed_s = self._time_s if changed else changed_s
        return impulses, changed_s

    def _block(
        self, end_s: float, samples_v: Sequence[float], force_n: float, speed_m_s: float, mode: ExplorationMode
    ) -> tuple[list[Impulse], bool]:
        """Process a block that ends at `end_s`; return its impulses, and whether the surface changed."""
        # rounded to 0.1 us, so that the time of a sample does not depend on the number that arrived with it
        end_s = round(end_s, 7)
        watch, before = self._watch, self._mode
        faulty = watch.fault is not None
        late = end_s - self._time_s > _GAP_S
        self._mode, self._time_s = mode, end_s
        resting = mode is not ExplorationMode.STROKING and speed_m_s < STROKING_M_S
        if watch.step(end_s, samples_v, force_n, resting, mode is ExplorationMode.FREE) is not None:
            if not faulty:
                self._forget()
            return [], False
        if mode is ExplorationMode.FREE:
            if before is not ExplorationMode.FREE:
                self._lose(end_s)
            return [], False
        if before is ExplorationMode.FREE and end_s - self._lost_s > CARRY_S:
            self._surface = None
        if mode is ExplorationMode.TAPPING or late:
            # the signal of a tap says nothing about the surface; the samples after it do
            self.interrupt()
        moved = 0.0 if mode is ExplorationMode.TAPPING else speed_m_s
        curves = self._path.step(samples_v, end_s, moved)
        impulses: list[Impulse] = []
        changed = False
        if curves:
            gain = self._law.gain(force_n, speed_m_s)
            noise_v2 = (self._law.noise_v / gain) ** 2
            for curve in curves:
                impulse, jumped = self._take_curve(curve, gain, noise_v2)
                if impulse is not None and mode is ExplorationMode.STROKING:
                    impulses.append(impulse)
                changed = changed or jumped
        return impulses, changed

    def _take_curve(self, curve: Curve, gain: float, noise_v2: float) -> tuple[Impulse | None, bool]:
        """Take one curvature, and the noise power of a sample for one newton, V^2."""
        curvature_v = curve.curvature_v / gain
        impulse = self._impulses.step(curve, curvature_v)
        if impulse is not None:
            self._roughness.groove(impulse.place_m)
        # before the threshold is known, any cell may be a groove
        if not self._impulses.known:
            return impulse, False
        noise = self._noise.power(curve.samples) * noise_v2
        settled = self._roughness.step(PathCell(curve.place_m, curvature_v * curvature_v, noise))
        updated = self._recognise(curve.place_m, settled, impulse)
        return impulse, (updated or self._roughness.changed) and self._change(curve.place_m)

    def _change(self, place_m: float) -> bool:
        """Return whether another surface has begun: the roughness jumped, or the filter is sure of another surface."""
        changed = self._roughness.changed
        sure, before = self._filter.sure, self._surface
        roughness = ln_roughness(self._roughness.roughness_v)
        if sure is not None and sure is not before:
            # a surface that was not calibrated may lie between two that were: then the surface is still the same
            patterned = before is not None and (sure.period_mm or before.period_mm) is not None
            if before is None or patterned or abs(roughness - self._ln_roughness) > DIFFERENT:
                changed = changed or before is not None
                self._surface = sure
        if self._roughness.changed:
            self._surface = None  # the recognition of the new surface is part of the same change
        if sure is not None and sure is self._surface:
            self._ln_roughness = roughness
        if not changed or place_m - self._changed_m < SETTLE_M:
            return False
        self._changed_m = place_m
        return True

    def _recognise(self, place_m: float, settled: PathCell | None, impulse: Impulse | None) -> bool:
        """Update the filter with grooves, roughness, and every LISTEN_M the path without grooves; return if updated."""
        updated = impulse is not None
        if self._moved_m is None:
            self._moved_m = place_m
        if impulse is not None:
            self._filter.groove(impulse.place_m - self._moved_m)
            self._moved_m = max(self._moved_m, impulse.place_m)
        elif place_m - BEHIND_M - self._moved_m >= LISTEN_M:
            way_m = place_m - BEHIND_M - self._moved_m
            self._filter.move(way_m)
            self._moved_m += way_m
            updated = True
        if settled is not None:
            self._settled.append(settled)
            if len(self._settled) == _LISTEN:
                power = sum(cell.power for cell in self._settled) / _LISTEN
                noise = sum(cell.noise for cell in self._settled) / _LISTEN
                self._filter.roughness(power, noise, LISTEN_M)
                self._settled = []
                updated = True
        return updated


def groove_rad_s(strength_v: float, groove_v: float | None) -> float:
    """Return the amplitude of a groove's impulse, rad/s, from its curvature for one newton, V.

    `groove_v` is that of the calibrated grooves; None if none was calibrated.
    """
    share = 1.0 if groove_v is None else strength_v / groove_v
    return GROOVE_RAD_S * min(max(share, FAINTEST), STRONGEST)


def _each(value: _Value | Sequence[_Value], count: int) -> Sequence[_Value]:
    """Return a value for each of `count` samples."""
    return value if isinstance(value, Sequence) else (value,) * count
