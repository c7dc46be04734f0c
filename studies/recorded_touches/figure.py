"""Figure of the recorded touches: share of right answers over time, for both methods and each choice of sensors."""

from pathlib import Path
from typing import Any

from studies.drawing import Data, Rows, curve, figure_file
from teletaction.plotting.figure_style import BLUE, ORANGE

_COLOURS = {"linear": ORANGE, "estimator": BLUE}
_DASHES = {"counted": "-", "even": ":"}


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    rows = data["accuracy"]
    sensors = list(dict.fromkeys(row["sensors"] for row in rows))
    with figure_file(path, 8.0, 3.6, dpi="figure") as figure:
        panels = figure.subplots(1, len(sensors), sharey=True)
        for axes, sensor in zip(panels, sensors, strict=True):
            for (method, prior), mine in _curves(rows, sensor).items():
                how = {"color": _COLOURS[method], "linestyle": _DASHES[prior], "label": f"{method}, {prior} prior"}
                curve(axes, mine, "t_s", "share", (1.0, 100.0), marker="o", **how)
            axes.set_title(sensor.replace(", ", ",\n"))
            axes.set_xlabel("s after first contact")
        panels[0].set_ylabel(f"right of {rows[0]['touches']}, %")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))


def _curves(rows: Rows, sensors: str) -> dict[tuple[str, str], list[dict[str, Any]]]:
    """Rows of one choice of sensors, by method and prior."""
    curves: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        if row["sensors"] == sensors:
            curves.setdefault((row["method"], row["prior"]), []).append(row)
    return curves
