"""Made-up strokes of a slow sensor of sixteen signals, over three surfaces."""

import numpy as np

from remote_site.texture.calibration.spectrum_calibration import LabelledStroke
from remote_site.traces.trace_files import StrokeTrace

RATE_HZ = 35.0
SURFACES = {"smooth": (0.004, 12.0), "waved": (0.02, 25.0), "fine": (0.02, 8.0)}
"""Relative unevenness, and the wavelength, mm, that it is strongest at."""
PLACES_MM = np.array([(x, y) for x in (0.0, 3.0, 6.0, 9.0) for y in (0.0, 3.0, 6.0, 9.0)])
PROFILE = {name: np.random.default_rng(k).normal(size=8000) for k, name in enumerate(SURFACES)}


def profile(surface, x_mm, y_mm):
    """Unevenness that is the same wherever it is asked again, and another for each track `y_mm`."""
    strength, wavelength_mm = SURFACES[surface]
    grid_mm = 0.25 * np.arange(8000)
    kernel_mm = 0.25 * np.arange(-200, 201)
    kernel = np.cos(2 * np.pi * kernel_mm / wavelength_mm) * np.exp(-0.5 * (kernel_mm / wavelength_mm) ** 2)
    rough = np.convolve(np.roll(PROFILE[surface], int(97 * y_mm)), kernel / np.linalg.norm(kernel), "same")
    return strength * np.interp(x_mm, grid_mm, rough)


def stroke(surface, load, speed_mm_s, seed, start_mm=50.0, length_mm=500.0, taxels=16):
    """A stroke under a load, over uneven ground, with the sensor shaken, tilted and noisy."""
    chance = np.random.default_rng(seed)
    t = np.arange(0.0, length_mm / speed_mm_s, 1.0 / RATE_HZ)
    x_mm = start_mm + speed_mm_s * t
    shaken = 0.05 * load / 200.0 * np.sin(2 * np.pi * 2.4 * t + chance.uniform(0, 6))
    tilted = 0.03 * np.sin(2 * np.pi * 1.7 * t + chance.uniform(0, 6))[:, None] * (PLACES_MM[:, 0] - 4.5) / 4.5
    local = np.column_stack([profile(surface, x_mm + x, y) for x, y in PLACES_MM])
    means = load * np.linspace(0.5, 1.5, 16)
    signals = means * (1.0 + shaken[:, None] + tilted + local) + 0.8 * chance.normal(size=(len(t), 16))
    names = tuple(f"taxel{k + 1}" for k in range(taxels))
    return StrokeTrace(t, signals[:, :taxels], signal_names=names, name=f"{surface}_{load}_{speed_mm_s:.0f}")


def folder_of(loads, seed=0, **how):
    """Labelled strokes of each surface under each load, at three speeds."""
    return [
        LabelledStroke(stroke(surface, load, speed, seed + 7 * k, **how), surface, speed / 1000.0)
        for surface in SURFACES
        for load in loads
        for k, speed in enumerate((20.0, 40.0, 80.0))
    ]
