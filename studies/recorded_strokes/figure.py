"""Panels of the recorded strokes: errors of the boards' periods, and fabrics at a pressure not learned from."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import Data, figure_file, where
from teletaction.plotting.figure_style import BLUE, GREEN, GREY, ORANGE, label_once

_SIGNALS = {"best": (BLUE, "o", "taxel that shows it best"), "mean": (ORANGE, "s", "mean of the taxels")}
_SPLITS = {
    "setting left out": (BLUE, "o"),
    "one setting learned": (ORANGE, "^"),
    "other half": (GREEN, "s"),
    "at random": (GREY, "x"),
}


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    with figure_file(path, 12.0, 4.8) as figure:
        panels = figure.subplots(1, 2)
        for axes, draw in zip(panels, (draw_boards, draw_fabrics), strict=True):
            draw(axes, data)


def draw_boards(axes: Axes, data: Data) -> None:
    """Error of each stroke's period with its standard deviation, in percent; strokes in the order of their names."""
    for signal, (colour, marker, label) in _SIGNALS.items():
        rows = where(data["boards"], signal=signal)
        found = [(place, row) for place, row in enumerate(rows) if row["period_mm"] is not None]
        axes.errorbar(
            [place + (0.15 if signal == "mean" else -0.15) for place, _ in found],
            [row["error_percent"] for _, row in found],
            [100.0 * row["period_sd_mm"] / row["true_mm"] for _, row in found],
            color=colour,
            marker=marker,
            markersize=4,
            linestyle="none",
            label=label,
        )
    true_mm = [row["true_mm"] for row in data["boards"] if row["signal"] == "best"]
    for period in dict.fromkeys(true_mm):
        middle = float(np.mean([place for place, own in enumerate(true_mm) if own == period]))
        axes.text(middle, 1.25, f"{period:g} mm", ha="center")
    axes.axhspan(-1.0, 1.0, color=GREY, alpha=0.12, linewidth=0)
    axes.set(ylim=(-1.5, 1.5), xticks=[], xlabel="strokes", ylabel="error of the period (%)")
    axes.set_title("Grooved boards: spatial period")
    label_once(axes, loc="lower right")


def draw_fabrics(axes: Axes, data: Data) -> None:
    """Share of fabrics recognised by each method; each setting and split is a point."""
    rows: Sequence[Mapping[str, Any]] = data["accuracy"]
    methods = list(dict.fromkeys(row["method"] for row in rows))
    for shift, (split, (colour, marker)) in zip((-0.3, -0.1, 0.1, 0.3), _SPLITS.items(), strict=True):
        for place, method in enumerate(methods):
            shares = [100.0 * row["share"] for row in rows if row["method"] == method and row["split"] == split]
            axes.plot(
                shares,
                np.full(len(shares), place + shift),
                color=colour,
                marker=marker,
                markersize=4,
                linewidth=0.8,
                label=split,
            )
    axes.set_yticks(range(len(methods)), methods)
    axes.invert_yaxis()
    axes.set(xlim=(0.0, 102.0), xlabel="right (%)", title="Fabrics: a point for each judged group")
    label_once(axes, loc="upper center", bbox_to_anchor=(0.4, -0.13), ncols=2)
