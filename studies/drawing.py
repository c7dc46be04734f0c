"""Draws the figures of the studies: a PNG file, its panels, and curves over two columns of rows."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from teletaction.plotting.figure_style import STYLE

Data = Mapping[str, Any]
Rows = Sequence[Mapping[str, Any]]
WIDEST_IN = 11.5
"""Largest width of a figure, inches: on a page of 960 px its text of 9.5 pt is then 11 px high."""


@contextmanager
def figure_file(
    path: Path, width_in: float, height_in: float, dpi: float = 150, layout: Any = "constrained"
) -> Iterator[Figure]:
    """Yield an empty figure of this size, inches, and write it as PNG on exit.

    Raises:
        ValueError: the figure is wider than WIDEST_IN.
    """
    if width_in > WIDEST_IN:
        raise ValueError(f"{path}: a figure of {width_in:g} inches cannot be read on a page; at most {WIDEST_IN:g}")
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width_in, height_in), layout=layout)
        FigureCanvasAgg(figure)
        yield figure
        figure.savefig(path, dpi=dpi)


def draw_panels(
    data: Data,
    path: Path,
    size_in: tuple[float, float],
    panels: Sequence[Sequence[Callable[[Axes, Data], None]]],
    **how: Any,
) -> None:
    """Draw lines of panels, each by a function of its axes and the data, and write a PNG of this size, inches."""
    with figure_file(path, *size_in) as figure:
        grid = figure.subplots(len(panels), len(panels[0]), squeeze=False, **how)
        for axes, draw in zip(grid.flat, chain(*panels), strict=True):
            draw(axes, data)


def where(rows: Rows, **values: Any) -> list[Mapping[str, Any]]:
    """Return the rows that have these values in these columns."""
    return [row for row in rows if all(row[name] == value for name, value in values.items())]


def curve(axes: Axes, rows: Rows, x: str, y: str, units: tuple[float, float] = (1.0, 1.0), **how: Any) -> None:
    """Draw a column of rows over another; each is multiplied by its unit, and None leaves a gap."""
    columns = [
        [np.nan if row[name] is None else unit * row[name] for row in rows]
        for name, unit in zip((x, y), units, strict=True)
    ]
    axes.plot(*columns, **how)
