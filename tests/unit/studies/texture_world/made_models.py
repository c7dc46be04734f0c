"""Makes haptic texture models of surfaces that do not exist, in the form of the public ones."""

from pathlib import Path

import numpy as np

SPEEDS_MM_S, FORCES_N = (0.0, 100.0, 220.0), (0.0, 1.5, 4.0)
ORDER_AR, ORDER_MA = 6, 4


def write_model(path: Path, material: str, seed: int) -> None:
    """Write one model: a resonance of its own, and a variance that grows with speed and force."""
    chance = np.random.default_rng(seed)
    resonance = chance.uniform(0.3, 2.6)
    loudness = chance.uniform(-7.0, -3.0)
    points = [(speed, force) for force in FORCES_N for speed in SPEEDS_MM_S]
    columns = len(SPEEDS_MM_S)
    corners = [
        corner
        for row in range(len(FORCES_N) - 1)
        for column in range(columns - 1)
        for first in [row * columns + column + 1]
        for corner in ((first, first + 1, first + columns), (first + 1, first + columns, first + columns + 1))
    ]
    models = "".join(model(resonance, loudness, *point) for point in points)
    lists = "".join(
        f"<{name}>{values(column)}</{name}>"
        for name, column in zip(("speedList", "forceList"), zip(*points, strict=True), strict=True)
    )
    triangles = "".join(f"<tri>{values(corner)}</tri>" for corner in corners)
    path.write_text(f"<modelSet><material>{material}</material>{lists}{triangles}{models}</modelSet>", "utf-8")


def model(resonance: float, loudness: float, speed_mm_s: float, force_n: float) -> str:
    """Return the model of one point."""
    even = np.pi * np.arange(1, ORDER_AR + 1) / (ORDER_AR + 1)
    # two frequencies beside each other make a resonance
    near = np.sort(np.concatenate([even[2:], [resonance * (1.0 + 0.001 * speed_mm_s), resonance + 0.25]]))
    zeros = np.pi * np.arange(1, ORDER_MA + 1) / (ORDER_MA + 1)
    variance = np.exp(loudness) * (speed_mm_s / 100.0) ** 1.5 * force_n**0.5
    return (
        f"<model><ARlsf>{values(near)}</ARlsf><MAlsf>{values(zeros)}</MAlsf>"
        f"<var>{variance:.8f}</var><gain>2.0</gain></model>"
    )


def values(numbers) -> str:
    """Return the elements of a list."""
    return "".join(f"<value>{number:.8f}</value>" for number in numbers)


def models_in(folder: Path, count: int) -> Path:
    """Write `count` models to a folder."""
    folder.mkdir(exist_ok=True)
    for number in range(count):
        write_model(folder / f"Models_{number:02d}.xml", f"made {number}", number)
    return folder
