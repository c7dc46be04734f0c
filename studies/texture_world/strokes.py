"""Renders strokes over textures at random speeds and forces, and measures them as a sensor does."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from remote_site.texture.motion_spectrum import StrokeSpectrum
from remote_site.texture.recorded.stroke_playback import EvenStroke
from remote_site.texture.recorded.stroke_spectrum import stroke_spectrum
from remote_site.texture.tip_path import RATE_HZ as SENSOR_HZ
from studies.texture_world.models import RATE_HZ, TextureModel

Array = NDArray[np.float64]
SPEED_MM_S, FORCE_N = (40.0, 180.0), (0.4, 3.0)
"""Ranges of a stroke's mean speed, mm/s, and force, N; those of a model end earlier where it does."""
WITHIN = (0.9, 0.85)
"""Largest mean speed and force, over the largest of the model."""
VARIATION = 0.15
"""Relative amplitude of the slow variation of speed and force within a stroke."""
VARIATION_HZ = (0.3, 1.2)
REST_S, START_S, SETTLED_S = 0.5, 0.05, 0.1
"""Rest before a stroke, duration of its start, and time from its begin until it is judged, s."""
LONGEST_S = 4.0
"""Longest judged part of a stroke, s."""
NOISE_M_S2 = 0.02
"""Noise of a sample of the sensor, rms, m/s^2."""
V_PER_M_S2 = 0.1
"""Sensitivity of the sensor, V/(m/s^2)."""
BLOCK = 10
"""Number of samples rendered with one filter."""


class Stroke(NamedTuple):
    """A rendered stroke, in arrays of one length: speed, mm/s, force, N, and acceleration, m/s^2, at 1000 Hz."""

    speed_mm_s: Array
    force_n: Array
    acceleration_m_s2: Array

    def even(self) -> EvenStroke:
        """Return the stroke at the rate of the texture sensor."""
        time_s = np.arange(len(self.speed_mm_s)) / RATE_HZ
        at_s = np.arange(0.0, time_s[-1], 1.0 / SENSOR_HZ)
        signal, force, speed = (
            np.interp(at_s, time_s, column) for column in (self.signal_v, self.force_n, self.speed_mm_s)
        )
        return EvenStroke(at_s, signal, force, 1e-3 * speed)

    @property
    def signal_v(self) -> Array:
        """Signal of the sensor, V."""
        return V_PER_M_S2 * self.acceleration_m_s2

    def steady(self, seconds: float) -> slice:
        """Samples of the judged part, from its begin for this time, s."""
        first = round((REST_S + SETTLED_S) * RATE_HZ)
        return slice(first, first + round(seconds * RATE_HZ))

    def spectrum(self, seconds: float) -> StrokeSpectrum:
        """Spectrum of the judged part; `seconds` is at least 0.13."""
        part = self.steady(seconds)
        speed_m_s, force_n = 1e-3 * float(self.speed_mm_s[part].mean()), float(self.force_n[part].mean())
        found = stroke_spectrum(self.signal_v[part], RATE_HZ, speed_m_s, force_n)
        assert found is not None, "a judged part is longer than a window"
        return found


def stroke_over(model: TextureModel, seed: int, place: int, number: int) -> Stroke:
    """Stroke a texture once; seed, place of the texture and number of the stroke decide speed, force and excitation.

    They are always three numbers: a generator ignores zeros at the end of its seed, so that (0, 1, 5) would be another
    stroke's (0, 1, 5, 0).
    """
    chance = np.random.default_rng([seed, place, number])
    speed, force = (
        chance.uniform(low, min(high, share * most))
        for (low, high), share, most in zip((SPEED_MM_S, FORCE_N), WITHIN, model.most, strict=True)
    )
    time_s = np.arange(round((REST_S + SETTLED_S + LONGEST_S) * RATE_HZ)) / RATE_HZ

    def varied() -> Array:
        hz, phase = chance.uniform(*VARIATION_HZ), chance.uniform(0.0, 2.0 * math.pi)
        return np.asarray(1.0 + VARIATION * np.sin(2.0 * math.pi * hz * time_s + phase))

    speed_mm_s = speed * varied() * np.clip((time_s - REST_S) / START_S, 0.0, 1.0)
    force_n = force * varied()
    sensed = rendered(model, speed_mm_s, force_n, chance) + chance.normal(0.0, NOISE_M_S2, len(time_s))
    return Stroke(speed_mm_s, force_n, sensed)


def rendered(model: TextureModel, speed_mm_s: Array, force_n: Array, chance: np.random.Generator) -> Array:
    """Return the acceleration of a stroke at 1000 Hz, m/s^2; a filter changes every BLOCK samples and keeps its state.

    Args:
        model: the texture.
        speed_mm_s: speed at each sample, (n,), mm/s; n is a multiple of BLOCK.
        force_n: force at each sample, (n,), N.
        chance: source of the excitation.
    """
    arma = model.at(speed_mm_s[BLOCK // 2 :: BLOCK], force_n[BLOCK // 2 :: BLOCK])
    excitation = np.repeat(arma.deviation, BLOCK) * chance.standard_normal(len(speed_mm_s))
    state = np.zeros(max(arma.numerator.shape[1], arma.denominator.shape[1]) - 1)
    out = np.empty(len(speed_mm_s))
    for block, (numerator, denominator) in enumerate(zip(arma.numerator, arma.denominator, strict=True)):
        part = slice(block * BLOCK, (block + 1) * BLOCK)
        out[part], state = lfilter(numerator, denominator, excitation[part], zi=state)
    return out


def own_ln_rms(model: TextureModel) -> float:
    """Return the ln rms of a model, m/s^2, over a grid of speeds and forces of the strokes; nothing is drawn."""
    speeds, forces = (
        np.linspace(low, min(high, share * most), 6)
        for (low, high), share, most in zip((SPEED_MM_S, FORCE_N), WITHIN, model.most, strict=True)
    )
    speed_mm_s, force_n = (grid.ravel() for grid in np.meshgrid(speeds, forces))
    return 0.5 * math.log(float(np.mean(model.at(speed_mm_s, force_n).rms() ** 2)))
