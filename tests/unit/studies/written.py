"""Tables, figures and panels of a study, made and looked at as far as a test can."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.registry import write_table

Data = dict[str, Any]


def write_tables(tables: Mapping[str, Sequence[Mapping[str, Any]]], folder: Path) -> None:
    """Write every table: each row has its line."""
    for name, rows in tables.items():
        write_table(folder / f"{name}.csv", rows)
        assert len((folder / f"{name}.csv").read_text("utf-8").splitlines()) == 1 + len(rows)


def draw_figure(plot: Callable[[Data, Path], object], data: Data, folder: Path, least_bytes: int = 10_000) -> None:
    """Draw a study's figure: it is no empty one."""
    plot(data, folder / "figure.png")
    assert (folder / "figure.png").stat().st_size > least_bytes


def draw_panels(panels: Iterable[Callable[[Axes, Data], object]], data: Data, folder: Path) -> None:
    """Draw some panels: each has a title and lines."""
    for draw in panels:
        figure = Figure()
        axes = figure.subplots()
        draw(axes, data)
        assert axes.get_title(loc="left")
        assert axes.lines
        figure.savefig(folder / "panel.png")
