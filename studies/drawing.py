"""Draws the figures of the studies: a PNG file, its panels, and the charts that several of them have."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from teletaction.plotting.figure_style import PALE, STYLE, plain_ticks

Array = NDArray[np.float64]
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


def log_axes(axes: Axes, x: Sequence[float] = (), y: Sequence[float] = ()) -> None:
    """Scale the axes that have ticks here logarithmically, with plain numbers at these ticks."""
    for name, ticks in (("x", x), ("y", y)):
        if ticks:
            axes.set(**{f"{name}scale": "log"})
            plain_ticks(getattr(axes, f"{name}axis"), ticks)


def named_lines(axes: Axes, names: Sequence[str], **how: Any) -> None:
    """Name the lines of a figure, 0 at the top, on the vertical axis."""
    axes.set_yticks(range(len(names)), names, **how)
    axes.invert_yaxis()


def stacked_bars(axes: Axes, places: Any, parts: Mapping[str, tuple[Sequence[float], str]], width: Any = 0.8) -> Array:
    """Stack parts of bars at places, each with its heights and colour, labelled by its name; returns the tops."""
    tops = np.zeros(len(places))
    for name, (heights, colour) in parts.items():
        axes.bar(places, heights, width, tops, color=colour, label=name)
        tops = tops + heights
    return tops


def share_map(
    axes: Axes,
    rows: Rows,
    columns: tuple[str, str, str],
    levels: Sequence[float],
    colours: Sequence[str],
    edges: str = PALE,
) -> None:
    """Draw a cell for each pair of values of two columns, coloured by the level of the third; None counts as 0."""
    x, y, share = columns
    across, along = (sorted({row[name] for row in rows}) for name in (x, y))
    shares = np.full((len(along), len(across)), np.nan)
    for row in rows:
        shares[along.index(row[y]), across.index(row[x])] = row[share] or 0.0
    shown = ListedColormap(list(colours))
    axes.pcolormesh(shares, cmap=shown, norm=BoundaryNorm(levels, shown.N), edgecolors=edges, linewidth=0.4)
    axes.set_xticks(np.arange(len(across)) + 0.5, [f"{value:g}" for value in across])
    axes.set_yticks(np.arange(len(along)) + 0.5, [f"{value:g}" for value in along])
    axes.grid(visible=False)


def keys_below(axes: Axes, columns: int, y: float = -0.2, **how: Any) -> None:
    """Draw the legend below the axes, if there is anything to explain."""
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="upper left", bbox_to_anchor=(-0.1, y), ncols=columns, columnspacing=1.0, **how)
