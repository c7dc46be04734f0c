"""Figure of the study of other objects: errors of the temperature and their stated intervals, over time."""

from pathlib import Path

from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, Rows, curve, figure_file, where
from studies.other_objects.run import CALIBRATIONS, OBJECTS
from studies.thermal_identification.figure import time_axis

_ROWS = (
    ("A", "object_within_sd", 100.0, "A: errors within\nthe stated 95 % (%)", (0.0, 102.0)),
    ("B", "object_within_sd", 100.0, "B: errors within\nthe stated 95 % (%)", (0.0, 102.0)),
    ("A", "object_median_k", 1.0, "A: median error (K)", (0.0, 2.0)),
    ("B", "object_median_k", 1.0, "B: median error (K)", (0.0, 2.0)),
    ("B", "object_stated", 100.0, "B: temperature\nstated (%)", (0.0, 102.0)),
)
"""World, column of the data, factor, label and range of each row of charts."""
_METHODS = (("1 finger", "-", "o"), ("5 staggered", "--", "s"))


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    with figure_file(path, WIDEST_IN, 10.5, dpi=130) as figure:
        figure.suptitle("Objects unlike those of calibration; colours: objects of calibration", fontsize=10)
        panels = figure.subplots(len(_ROWS), len(OBJECTS), sharex=True)
        for row, (world, column, factor, label, limits) in zip(panels, _ROWS, strict=True):
            for axes, objects in zip(row, OBJECTS, strict=True):
                _draw(axes, where(data["shares"], world=world, objects=objects.name), column, factor)
                axes.set_ylim(*limits)
                if column == "object_within_sd":
                    axes.axhline(95.0, color="black", linewidth=0.8, linestyle=":")
            row[0].set_ylabel(label)
        for axes, objects in zip(panels[0], OBJECTS, strict=True):
            axes.set_title(objects.name, fontsize=9)
        handles, labels = panels[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(CALIBRATIONS))


def _draw(axes: Axes, rows: Rows, column: str, factor: float) -> None:
    for number, how in enumerate(CALIBRATIONS):
        for method, dash, marker in _METHODS:
            mine = [row for row in where(rows, calibration=how, method=method) if row[column] is not None]
            style = {"color": f"C{number}", "linestyle": dash, "marker": marker, "markersize": 3}
            curve(axes, mine, "t_s", column, (1.0, factor), label=f"{how}, {method}", **style)
    time_axis(axes, sorted({row["t_s"] for row in rows}))
