"""Presses of a power-law object that yields by 1 N at a given depth, as arrays and as files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from remote_site.traces.press_files import Press


def spring_presses(
    count: int,
    *,
    exponent: float = 1.0,
    stiffness_n_m: float = 500.0,
    spread: float = 0.2,
    deepest_mm: float = 3.0,
    samples: int = 10,
    contact_mm: float = -0.03,
    noise_n: float = 0.01,
    seed: int = 0,
) -> list[Press]:
    """Presses F = (d / d1)^p, with depth d below contact and d1 that of 1 N; d1 varies between places by `spread`."""
    random = np.random.default_rng(seed)
    depth_mm = np.linspace(0.0, deepest_mm, samples)
    presses = []
    for press in range(count):
        at_1_n_mm = 1000.0 / stiffness_n_m * np.exp(spread * random.standard_normal())
        law_n = (np.maximum(depth_mm - contact_mm, 0.0) / at_1_n_mm) ** exponent
        presses.append(Press(press, depth_mm, law_n + noise_n * random.standard_normal(samples)))
    return presses


def write_presses(folder: Path, presses: Sequence[Press]) -> Path:
    """Write presses to a file in this folder and return its path."""
    rows = [
        f"{press.press},{depth_mm!r},{force_n!r}\n"
        for press in presses
        for depth_mm, force_n in zip(press.depth_mm.tolist(), press.force_n.tolist(), strict=True)
    ]
    path = folder / "presses.csv"
    path.write_text("press,depth_mm,force_n\n" + "".join(rows), "utf-8")
    return path
