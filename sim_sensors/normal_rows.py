"""Noise of a few sensors a step, drawn for many steps at a time: the numbers are those of a draw in each step."""

from collections.abc import Iterator

import numpy as np

_ROWS = 256
"""Drawn at a time."""


def normal_rows(rng: np.random.Generator, count: int) -> Iterator[list[float]]:
    """Standard normal numbers without end, in rows of `count`. Nothing else may draw from `rng`."""
    while True:
        yield from rng.standard_normal((_ROWS, count)).tolist()
