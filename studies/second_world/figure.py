"""Figure of the study of two worlds: right answers, errors of temperature and their stated intervals, and names."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, Rows, curve, figure_file, where
from studies.thermal_identification.figure import METHODS, time_axis
from studies.thermal_identification.operating_curve import draw_operating_curve

_SHOWN = ("1 finger", "2 staggered", "5 staggered")
_COLUMNS = (
    ("right", 100.0, "likeliest material is right (%)", (0.0, 102.0)),
    ("wrong", 100.0, "named, and wrong (%)", (0.0, 5.0)),
    ("object_median_k", 1.0, "error of object temperature, median (K)", (0.0, 1.5)),
    ("object_within_sd", 100.0, "errors within the stated 95 % (%)", (0.0, 102.0)),
)
"""Column of the data, factor, label and range of each chart."""


def reference_of(method: str) -> str:
    """Return the name of the reference that has as many fingers as a method of the estimator."""
    return f"reference, {method}"


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    sets = data["sets"]
    with figure_file(path, WIDEST_IN, 6.8 * len(sets) + 0.8, dpi=130) as figure:
        figure.suptitle("The shipped identification in two worlds of sensors and objects", fontsize=10)
        panels = figure.subplots(2 * len(sets), 3, squeeze=False).reshape(len(sets), 6)
        for row, each in zip(panels, sets, strict=True):
            row[5].set_axis_off()
            count = len(each["names"])
            rows = where(data["accuracy"], world=each["world"], materials=count)
            for axes, (column, factor, label, limits) in zip(row, _COLUMNS, strict=False):
                _draw(axes, rows, column, factor)
                axes.set_ylabel(label)
                axes.set_ylim(*limits)
            row[0].set_title(
                f"World {each['world']}: {count} materials; kinds of sensors: {each['kinds']}; touches of each: "
                f"{each['test']} judged; for calibration: {each['calibration']}, for the reference: {each['learning']}",
                loc="left",
                fontsize=9,
            )
            row[3].axhline(95.0, color="black", linewidth=0.8, linestyle=":")
            names = where(data["names"], world=each["world"], materials=count)
            draw_operating_curve(row[4], names, {method: METHODS[method][::2] for method in _SHOWN})
        handles, labels = panels[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(_SHOWN))


def _draw(axes: Axes, rows: Rows, column: str, factor: float) -> None:
    for method in _SHOWN:
        colour, dash, marker = METHODS[method]
        for name, how in (
            (method, {"linestyle": dash, "marker": marker, "markersize": 4}),
            (reference_of(method), {"linestyle": "--", "linewidth": 1.0}),
        ):
            mine: list[Mapping[str, Any]] = [row for row in where(rows, method=name) if row[column] is not None]
            if mine:
                curve(axes, mine, "t_s", column, (1.0, factor), color=colour, label=name, **how)
    time_axis(axes, sorted({row["t_s"] for row in rows}))
