"""Figure of the study of thermal identification: speed and accuracy above, failures in the middle, cost below."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, Rows, curve, figure_file, keys_below, log_axes, where
from studies.thermal_identification.map_figure import (
    draw_changes,
    draw_differences,
    draw_spread,
    draw_untrained,
    map_keys,
)
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PLUM, PURPLE, RED, SKY, plain_ticks

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
_COLUMNS = {
    "one finger": ("paper", "good exponential", "1 finger", "1 finger, strangers among them", "reference"),
    "2 fingers on one object": ("2 equal", "2 staggered", "reference, 2 staggered"),
    "3 fingers on one object": ("3 equal", "3 staggered"),
    "5 fingers on one object": ("5 equal", "5 staggered"),
}
"""Methods of each column of small multiples."""
_PERCENT = 100.0
_COST_AT_S = 1.0
_FEW = 10
"""Fewest answers in a drawn bin of probability."""


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    with figure_file(path, WIDEST_IN, 24.0, dpi=130) as figure:
        parts = figure.subfigures(3, 1, height_ratios=(9.6, 5.2, 9.2), squeeze=False, hspace=0.03)
        speed, failure, below = parts[:, 0]
        _draw_speed(speed, data)
        _draw_failures(failure, data)
        _draw_rest(below, data)


def _draw_speed(figure: Any, data: Mapping[str, Any]) -> None:
    """Draw a column for each number of fingers: right answers of 4 and of 12 materials, and errors of temperature."""
    learned = data["learning_touches"]
    figure.suptitle(
        f"Speed and accuracy: simulated touches, {data['calibration_touches']} a material calibrated it.\n"
        f"The reference learned from {learned['4']} a material (of twelve: {learned['12']}). "
        "Grey: one finger",
        fontsize=10,
    )
    four, twelve = (where(data["accuracy"], materials=count) for count in (4, 12))
    places = figure.subplots(3, len(_COLUMNS), sharex=True, sharey="row")
    for column, (title, methods) in zip(places.T, _COLUMNS.items(), strict=True):
        upper, middle, lower = column
        _draw_right(upper, four, methods)
        _draw_right(middle, twelve, methods)
        _draw_errors(lower, four, data["bounds"], methods)
        upper.set_title(title, loc="left")
        time_axis(lower, (0.25, 0.5, 1, 2, 3, 7))
        lower.set_ylim(0.02, 8.0)
        drawn = [pair for axes in (upper, lower) for pair in zip(*axes.get_legend_handles_labels(), strict=True)]
        keys = {label: handle for handle, label in drawn}
        place = {"loc": "upper left", "bbox_to_anchor": (-0.15, -0.3), "borderaxespad": 0.0}
        lower.legend(list(keys.values()), list(keys), fontsize=8, **place)
    for axes, label in zip(
        places[:, 0],
        ("4 materials: likeliest is right (%)", "12 materials: likeliest is right (%)", "temperature, rms error (K)"),
        strict=True,
    ):
        axes.set_ylabel(label)


def _draw_right(axes: Axes, rows: Rows, methods: Sequence[str]) -> None:
    _draw_one_finger(axes, rows, methods, "right", _PERCENT)
    for method in methods:
        mine = [row for row in rows if row["method"] == method and row["right"] is not None]
        if mine:
            curve(axes, mine, "t_s", "right", (1.0, _PERCENT), **_how(method))
    ones = where(rows, method="1 finger") if "1 finger" in methods else []
    if ones:
        wrong = [_PERCENT * row["wrong"] for row in ones]
        named = [_PERCENT * row["identified"] for row in ones]
        axes.fill_between([row["t_s"] for row in ones], named, color=SKY, alpha=0.25, label="1 finger: identified")
        axes.fill_between([row["t_s"] for row in ones], wrong, color=RED, alpha=0.8, label="of these wrong")
    axes.set_ylim(0.0, 102.0)


def _draw_one_finger(axes: Axes, rows: Rows, methods: Sequence[str], value: str, unit: float) -> None:
    """Draw one finger in grey behind more fingers."""
    mine = [row for row in rows if row["method"] == "1 finger" and row[value] is not None]
    if "1 finger" not in methods and mine:
        curve(axes, mine, "t_s", value, (1.0, unit), color=GREY, linewidth=0.8)


def _how(method: str) -> dict[str, Any]:
    colour, dash, marker = METHODS[method]
    return {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4, "label": method}


def time_axis(axes: Axes, times: Sequence[float]) -> None:
    """Draw time after contact on a logarithmic axis, so that equal factors have equal lengths."""
    log_axes(axes, times)
    axes.set_xlabel("time after contact (s)")


def _draw_errors(axes: Axes, rows: Rows, bounds: Rows, methods: Sequence[str]) -> None:
    """Draw the errors of objects within 3 K of ambient, and the bounds of the same fingers."""
    _draw_one_finger(axes, rows, methods, "object_rms_k", 1.0)
    for method in methods:
        mine = [row for row in rows if row["method"] == method and row["object_rms_k"]]
        if mine:
            curve(axes, mine, "t_s", "object_rms_k", **_how(method))
    for plates, fingers in (("equal", 1), ("staggered", 2), ("staggered", 5)):
        mine = where(bounds, plates=plates, fingers=fingers)
        if (f"{fingers} {plates}" if fingers > 1 else "1 finger") not in methods:
            continue
        times = sorted({row["t_s"] for row in mine})
        least = [np.sqrt(np.mean([row["object_sd_k"] ** 2 for row in mine if row["t_s"] == t])) for t in times]
        axes.plot(times, least, color=BLACK, linestyle=":", linewidth=1.0, label="bound of the temperature's error")
    log_axes(axes, y=(0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0))


def _draw_failures(figure: Any, data: Mapping[str, Any]) -> None:
    figure.suptitle(
        "Failures, one finger, 4 materials. Colour: share with the right likeliest material;\n"
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
    (untrained, honest), (cost, scaling) = figure.subplots(2, 2)
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
    keys_below(axes, 1, -0.22, fontsize=8)


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
    keys_below(axes, 2, -0.22, fontsize=8)


def _draw_scaling(axes: Axes, rows: Rows) -> None:
    counts = [row["materials"] for row in rows]
    for part, colour, label in (
        ("early", RED, "first 0.2 s: every hypothesis"),
        ("all", BLUE, "mean of 2 s"),
        ("late", GREEN, "later: likely hypotheses"),
    ):
        curve(axes, rows, "materials", f"us_{part}", (1.0, 1e-3), color=colour, marker="o", markersize=4, label=label)
    axes.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_xlabel("calibrated materials")
    axes.set_xticks(counts)
    axes.set(ylabel="ms per update, one finger (limit 1)", ylim=(0.0, None), xlim=(0.0, None))
    axes.set_title("cost and number of materials", loc="left")
    keys_below(axes, 1, -0.22, fontsize=8)
