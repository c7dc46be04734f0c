"""Draw the noise of many steps at once, with the same numbers as one draw for each step."""

from collections.abc import Iterator

import numpy as np

_ROWS = 256
"""Number of rows drawn at once."""


def normal_rows(rng: np.random.Generator, count: int) -> Iterator[list[float]]:
    """Yield rows of `count` standard normal numbers without end. Nothing else may draw from `rng`."""
    while True:
        yield from rng.standard_normal((_ROWS, count)).tolist()
