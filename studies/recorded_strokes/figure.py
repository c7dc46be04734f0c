"""Panels of the recorded strokes: periods of boards and of made-up strokes, and fabrics at another pressure."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from scipy.stats import binomtest

from studies.counting import grouped
from studies.drawing import WIDEST_IN, Data, draw_panels, named_lines, where
from teletaction.plotting.figure_style import BLUE, GREEN, GREY, ORANGE, label_once

_SIGNALS = {"best": (BLUE, "o", "taxel that shows it best"), "mean": (ORANGE, "s", "mean of the taxels")}
_MADE = {"all taxels": BLUE, "mean": ORANGE, "one taxel": GREY}
_SPLITS = {
    "setting left out": (BLUE, "o"),
    "one setting learned": (ORANGE, "^"),
    "other half": (GREEN, "s"),
    "at random": (GREY, "x"),
}


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    draw_panels(data, path, (WIDEST_IN, 9.2), ((draw_boards, draw_fabrics), (draw_speeds, draw_coverage)))


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


def draw_speeds(axes: Axes, data: Data) -> None:
    """Draw periods of another line (solid) and missing ones (dashed) in percent of the made-up strokes, by speed."""
    for signals, colour in _MADE.items():
        rows = by_speed(data["made_by_speed"], signals)
        for column, line in (("wrong", "-"), ("none", "--")):
            shares = [100.0 * row[column] / row["strokes"] for row in rows]
            label = f"{signals}, {'another line' if column == 'wrong' else 'no period'}"
            axes.plot([row["speed_mm_s"] for row in rows], shares, line, color=colour, marker="o", ms=4, label=label)
    axes.set(ylim=(0.0, 45.0), xlabel="speed (mm/s)", ylabel="strokes (%)", title="Made-up strokes: no right period")
    label_once(axes, loc="upper center", fontsize="small", ncols=2)


def by_speed(rows: Sequence[Mapping[str, Any]], signals: str) -> list[dict[str, float]]:
    """Return the counts of these signals at each speed, both motions together."""
    columns = ("strokes", "none", "wrong", "answers", "inside_95")
    return [
        {"speed_mm_s": speed, **{name: sum(row[name] for row in part) for name in columns}}
        for (speed,), part in grouped(where(rows, signals=signals), "speed_mm_s").items()
    ]


def draw_coverage(axes: Axes, data: Data) -> None:
    """Draw the share of periods within their 95 % intervals, with its own interval; wrong periods count as outside."""
    made, changed = by_speed(data["made_by_speed"], "all taxels"), where(data["changed_boards"], signals="all taxels")
    rows: list[tuple[str, Mapping[str, Any], str]]
    rows = [(f"made-up, {row['speed_mm_s']:g} mm/s", row, BLUE) for row in made if row["answers"]]
    rows += [(row["change"], row, GREEN) for row in changed if row["answers"]]
    for place, (_, row, colour) in enumerate(rows):
        low, high = binomtest(row["inside_95"], row["answers"]).proportion_ci()
        axes.plot([100.0 * low, 100.0 * high], [place, place], color=colour, linewidth=1.2)
        axes.plot(100.0 * row["inside_95"] / row["answers"], place, "o", color=colour, ms=4)
    axes.axvspan(90.0, 100.0, color=GREY, alpha=0.12, linewidth=0)
    axes.axvline(95.0, color=GREY, linewidth=0.8)
    named_lines(axes, [f"{name} ({row['answers']})" for name, row, _ in rows])
    axes.set(xlim=(50.0, 101.0), xlabel="inside the 95 % interval (%)", title="Stated deviation of the period")


def draw_fabrics(axes: Axes, data: Data) -> None:
    """Share of fabrics recognised by each method; each setting and split is a point."""
    rows: Sequence[Mapping[str, Any]] = data["accuracy"]
    methods = list(dict.fromkeys(row["method"] for row in rows))
    for shift, (split, (colour, marker)) in zip((-0.3, -0.1, 0.1, 0.3), _SPLITS.items(), strict=True):
        for place, method in enumerate(methods):
            shares = [100.0 * row["share"] for row in where(rows, method=method, split=split)]
            at = [place + shift] * len(shares)
            axes.plot(shares, at, color=colour, marker=marker, markersize=4, linewidth=0.8, label=split)
    named_lines(axes, methods)
    axes.set(xlim=(0.0, 102.0), xlabel="right (%)", title="Fabrics: a point for each judged group")
    label_once(axes, loc="upper center", bbox_to_anchor=(0.4, -0.13), ncols=2)
