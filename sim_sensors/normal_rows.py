"""Draws the noise of many steps at a time, with the numbers of one draw for each step."""

from collections.abc import Iterator

import numpy as np

_ROWS = 256
"""Drawn at a time."""


def normal_rows(rng: np.random.Generator, count: int) -> Iterator[list[float]]:
    """Standard normal numbers without end, in rows of `count`. Nothing else may draw from `rng`."""
    while True:
        yield from rng.standard_normal((_ROWS, count)).tolist()
