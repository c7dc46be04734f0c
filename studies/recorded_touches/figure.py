"""Figure of the recorded touches: share of right answers over time, for both methods and each choice of sensors."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from teletaction.plotting.figure_style import BLUE, ORANGE, STYLE

_COLOURS = {"linear": ORANGE, "estimator": BLUE}
_DASHES = {"counted": "-", "even": ":"}


def plot(data: Mapping[str, Any], path: Path) -> None:
    """Draw the study's data as PNG."""
    rows = data["accuracy"]
    sensors = list(dict.fromkeys(row["sensors"] for row in rows))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 3.6), layout="constrained")
        FigureCanvasAgg(figure)
        panels = figure.subplots(1, len(sensors), sharey=True)
        for axes, sensor in zip(panels, sensors, strict=True):
            for (method, prior), mine in _curves(rows, sensor).items():
                axes.plot(
                    [row["t_s"] for row in mine],
                    [100.0 * row["share"] for row in mine],
                    color=_COLOURS[method],
                    linestyle=_DASHES[prior],
                    marker="o",
                    label=f"{method}, {prior} prior",
                )
            axes.set_title(sensor.replace(", ", ",\n"))
            axes.set_xlabel("s after first contact")
        panels[0].set_ylabel(f"right of {rows[0]['touches']}, %")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        figure.savefig(path)


def _curves(rows: list[dict[str, Any]], sensors: str) -> dict[tuple[str, str], list[dict[str, Any]]]:
    """Rows of one choice of sensors, by method and prior."""
    curves: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        if row["sensors"] == sensors:
            curves.setdefault((row["method"], row["prior"]), []).append(row)
    return curves
