"""Figure of the study of thermal identification: speed and accuracy above, failures in the middle, cost below."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import Data, Rows, curve, figure_file, where
from studies.thermal_identification.map_figure import (
    draw_changes,
    draw_differences,
    draw_spread,
    draw_untrained,
    map_keys,
)
from teletaction.plotting.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PLUM,
    PURPLE,
    RED,
    SKY,
    plain_ticks,
)

METHODS: Mapping[str, tuple[str, Any, str]] = {
    "paper": (RED, ":", "x"),
    "good exponential": (ORANGE, "--", "+"),
    "1 finger": (BLUE, "-", "o"),
    "1 finger, strangers among them": (SKY, "-", "o"),
    "2 equal": (GREEN, "--", "s"),
    "2 staggered": (GREEN, "-", "s"),
    "3 equal": (PURPLE, "--", "^"),
    "3 staggered": (PURPLE, "-", "^"),
    "5 equal": (PLUM, "--", "D"),
    "5 staggered": (PLUM, "-", "D"),
    "reference": (BLACK, "-.", ""),
    "reference, 2 staggered": (GREY, "-.", ""),
}
"""Colour, dash and marker of each method."""
_ALONE = ("paper", "good exponential", "1 finger", "reference")
_PERCENT = 100.0
_COST_AT_S = 1.0
_FEW = 10
"""Fewest answers in a drawn bin of probability."""


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    with figure_file(path, 14.0, 14.5, dpi=130) as figure:
        parts = figure.subfigures(3, 1, height_ratios=(4.3, 4.8, 4.6), squeeze=False, hspace=0.03)
        speed, failure, below = parts[:, 0]
        _draw_speed(speed, data)
        _draw_failures(failure, data)
        _draw_rest(below, data)


def _draw_speed(figure: Any, data: Mapping[str, Any]) -> None:
    figure.suptitle(
        f"Speed and accuracy: simulated touches, {data['calibration_touches']} a material calibrated it; the reference "
        f"learned from {data['learning_touches']['4']} a material (of twelve: {data['learning_touches']['12']})",
        fontsize=10,
    )
    alone, hands, twelve, error = figure.subplots(1, 4)
    rows = data["accuracy"]
    four = where(rows, materials=4)
    _draw_right(alone, four, _ALONE, "4 materials, one finger")
    together = [method for method in METHODS if method not in _ALONE]
    _draw_right(hands, four, ("1 finger", *together), "4 materials, fingers on one object")
    _draw_right(twelve, where(rows, materials=12), tuple(METHODS), "12 materials")
    alone.set_ylabel("likeliest material is right (%)")
    _draw_errors(error, four, data["bounds"])
    keys = {label: handle for axes in (alone, hands, error) for handle, label in _keys(axes)}
    figure.legend(list(keys.values()), list(keys), loc="outside lower center", ncols=7)


def _keys(axes: Axes) -> list[tuple[Any, str]]:
    return list(zip(*axes.get_legend_handles_labels(), strict=True))


def _draw_right(axes: Axes, rows: Rows, methods: Sequence[str], title: str) -> None:
    times = sorted({row["t_s"] for row in rows})
    for method in methods:
        mine = [row for row in rows if row["method"] == method and row["right"] is not None]
        if mine:
            colour, dash, marker = METHODS[method]
            how = {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4, "label": method}
            curve(axes, mine, "t_s", "right", (1.0, _PERCENT), **how)
    ones = where(rows, method="1 finger")
    if ones:
        wrong = [_PERCENT * row["wrong"] for row in ones]
        named = [_PERCENT * row["identified"] for row in ones]
        axes.fill_between([row["t_s"] for row in ones], named, color=SKY, alpha=0.25, label="1 finger: identified")
        axes.fill_between([row["t_s"] for row in ones], wrong, color=RED, alpha=0.8, label="of these wrong")
    time_axis(axes, times)
    axes.set_ylim(0.0, 102.0)
    axes.set_title(title, loc="left")


def time_axis(axes: Axes, times: Sequence[float]) -> None:
    """Draw time after contact on a logarithmic axis, so that equal factors have equal lengths."""
    axes.set_xscale("log")
    plain_ticks(axes.xaxis, times)
    axes.set_xlabel("time after contact (s)")


def _draw_errors(axes: Axes, rows: Rows, bounds: Rows) -> None:
    for method, (colour, dash, marker) in METHODS.items():
        mine = [row for row in rows if row["method"] == method and row["object_rms_k"]]
        if mine:
            how = {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4, "label": method}
            curve(axes, mine, "t_s", "object_rms_k", **how)
    for plates, fingers, dash in (("equal", 1, "-"), ("staggered", 2, "--"), ("staggered", 5, ":")):
        mine = where(bounds, plates=plates, fingers=fingers)
        times = sorted({row["t_s"] for row in mine})
        least = [np.sqrt(np.mean([row["object_sd_k"] ** 2 for row in mine if row["t_s"] == t])) for t in times]
        label = f"bound, {fingers} {plates if fingers > 1 else 'finger'}"
        axes.plot(times, least, color=BLACK, linestyle=dash, linewidth=0.8, label=label)
    times = sorted({row["t_s"] for row in rows})
    time_axis(axes, times)
    axes.set_yscale("log")
    plain_ticks(axes.yaxis, (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0))
    axes.set(ylim=(0.02, 8.0), ylabel="object's temperature, rms error (K)")
    axes.set_title("4 materials, object within ±3 K of ambient", loc="left")


def _draw_failures(figure: Any, data: Mapping[str, Any]) -> None:
    figure.suptitle(
        "Failures, one finger, 4 materials. Colour: share with the right likeliest material; "
        "numbers: per cent of touches named right (black) and named wrong (red), omitted if 0",
        fontsize=10,
    )
    noises = sorted({row["noise_k"] for row in data["difference"]})
    places = figure.subplots(2, max(len(noises), 2))
    for axes in places[0, len(noises) :]:
        axes.set_axis_off()
    draw_differences(places[0, : len(noises)], data["difference"])
    rest = places[1]
    draw_spread(rest[0], data["spread"])
    draw_changes(rest[1], data["contact"])
    for axes in rest[2:]:
        axes.set_axis_off()
    figure.legend(handles=map_keys(), loc="outside lower center", ncols=6)


def _draw_rest(figure: Any, data: Mapping[str, Any]) -> None:
    untrained, honest, cost, scaling = figure.subplots(1, 4, width_ratios=(1.35, 1.0, 1.0, 0.9))
    draw_untrained(untrained, data["untrained"])
    _draw_reliability(honest, data["reliability"])
    _draw_cost(cost, data)
    _draw_scaling(scaling, data["cost_by_materials"])


def _draw_reliability(axes: Axes, rows: Rows) -> None:
    axes.plot([0.0, 100.0], [0.0, 100.0], color=GREY, linewidth=0.8)
    for count, dash in ((4, "-"), (12, "--")):
        for method in ("1 finger", "1 finger, strangers among them", "2 staggered", "reference"):
            mine = [r for r in rows if r["method"] == method and r["materials"] == count and r["answers"] >= _FEW]
            colour, _, marker = METHODS[method]
            claimed, right = ([_PERCENT * r[name] for r in mine] for name in ("claimed", "right"))
            if mine:
                axes.plot(claimed, right, color=colour, linestyle=dash, marker=marker, markersize=4)
                sizes = [4.0 + 0.15 * r["answers"] for r in mine]
                axes.scatter(claimed, right, s=sizes, color=colour, alpha=0.3, linewidths=0)
                axes.plot([], [], color=colour, linestyle=dash, label=f"{method}, {count} materials")
    axes.set(xlabel="probability claimed (%)", ylabel="right (%)")
    axes.set_title("reliability, from 0.5 s (area: answers)", loc="left")
    _keys_below(axes, 1)


def _draw_cost(axes: Axes, data: Data) -> None:
    four = [row for row in data["accuracy"] if row["materials"] == 4 and row["right"] is not None]
    at_s = min((row["t_s"] for row in four if row["method"] == "reference"), key=lambda t_s: abs(t_s - _COST_AT_S))
    right = {row["method"]: row["right"] for row in four if row["t_s"] == at_s}
    for row in data["cost"]:
        together = row["fingers"] > 1
        names = [f"{row['fingers']} {plates}" for plates in ("equal", "staggered")] if together else [row["method"]]
        for method in names:
            if method in right:
                colour, dash, marker = METHODS[method]
                axes.plot(
                    row["ratio_all"],
                    _PERCENT * right[method],
                    marker=marker or "*",
                    markersize=7,
                    color=colour,
                    markerfacecolor="none" if dash == "--" else colour,
                    linestyle="none",
                    label=method,
                )
    axes.set_xscale("log")
    axes.set(xlabel="cost per finger and update\n(100 x 100 matrix products)", ylabel=f"right at {at_s:g} s (%)")
    axes.set_title("cost and accuracy, 4 materials", loc="left")
    plain_ticks(axes.xaxis, (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100))
    axes.margins(x=0.1)
    _keys_below(axes, 2)


def _draw_scaling(axes: Axes, rows: Rows) -> None:
    counts = [row["materials"] for row in rows]
    for part, colour, label in (
        ("early", RED, "first 0.2 s: every hypothesis"),
        ("all", BLUE, "mean of 2 s"),
        ("late", GREEN, "later: likely hypotheses"),
    ):
        axes.plot(
            counts, [row[f"us_{part}"] / 1e3 for row in rows], color=colour, marker="o", markersize=4, label=label
        )
    axes.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_xlabel("calibrated materials")
    axes.set_xticks(counts)
    axes.set(ylabel="ms per update, one finger (limit 1)", ylim=(0.0, None), xlim=(0.0, None))
    axes.set_title("cost and number of materials", loc="left")
    _keys_below(axes, 1)


def _keys_below(axes: Axes, columns: int) -> None:
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="upper left", bbox_to_anchor=(-0.1, -0.22), fontsize=8, ncols=columns, columnspacing=1.0)
