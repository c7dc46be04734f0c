"""Figure of the recorded touches: share of right answers over time, for both methods and each choice of sensors."""

from itertools import product
from pathlib import Path

from studies.drawing import Data, curve, figure_file, where
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
            for method, prior in product(_COLOURS, _DASHES):
                if mine := where(rows, sensors=sensor, method=method, prior=prior):
                    how = {"color": _COLOURS[method], "linestyle": _DASHES[prior], "label": f"{method}, {prior} prior"}
                    curve(axes, mine, "t_s", "share", (1.0, 100.0), marker="o", **how)
            axes.set_title(sensor.replace(", ", ",\n"))
            axes.set_xlabel("s after first contact")
        panels[0].set_ylabel(f"right of {rows[0]['touches']}, %")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
