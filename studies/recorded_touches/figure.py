"""Figure of the recorded touches: share of right answers over time, and the operating curve of naming, by sensors."""

from itertools import product
from pathlib import Path

from studies.drawing import WIDEST_IN, Data, curve, figure_file, where
from studies.thermal_identification.operating_curve import draw_operating_curve
from teletaction.plotting.figure_style import BLUE, GREEN, ORANGE, SKY

_COLOURS = {"linear": ORANGE, "estimator": BLUE}
_DASHES = {"counted": "-", "even": ":"}
_NAMING = ((SKY, "o"), (GREEN, "s"), (BLUE, "D"))
"""Colour and marker of each choice of sensors in the operating curve."""


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    rows = data["accuracy"]
    sensors = list(dict.fromkeys(row["sensors"] for row in rows))
    with figure_file(path, WIDEST_IN, 7.6) as figure:
        right, naming = figure.subfigures(2, 1, squeeze=False)[:, 0]
        panels = right.subplots(1, len(sensors), sharey=True)
        for axes, sensor in zip(panels, sensors, strict=True):
            for method, prior in product(_COLOURS, _DASHES):
                if mine := where(rows, sensors=sensor, method=method, prior=prior):
                    how = {"color": _COLOURS[method], "linestyle": _DASHES[prior], "label": f"{method}, {prior} prior"}
                    curve(axes, mine, "t_s", "share", (1.0, 100.0), marker="o", **how)
            axes.set_title(sensor.replace(", ", ",\n"))
            axes.set_xlabel("s after first contact")
        panels[0].set_ylabel(f"right of {rows[0]['touches']}, %")
        handles, labels = panels[0].get_legend_handles_labels()
        right.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        axes = naming.subplots()
        names = data["names"]
        methods = list(dict.fromkeys(row["method"] for row in names))
        draw_operating_curve(axes, names, dict(zip(methods, _NAMING, strict=False)))
        axes.set_title("estimator")
        axes.legend(loc="center right", fontsize="small")
