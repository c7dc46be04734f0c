"""Figure of the texture study: accuracy, roughness before and after normalisation, grooves, latch-up and drift."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, Rows, figure_file, log_axes, where
from teletaction.plotting.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    SKY,
    plain_ticks,
    shown_name,
)

_COLOURS = (RED, BLUE, ORANGE, GREEN)
_MARKS = "osD^"
_MILLIVOLTS = (1, 3, 10, 30, 100, 300, 1000)
_SURFACES = (SKY, BLUE, BLACK, GREEN, ORANGE, PURPLE)


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    with figure_file(path, WIDEST_IN, 12.0) as figure:
        axes = figure.subplots(3, 3)
        _draw_accuracy(axes[0, 0], data["accuracy"])
        _draw_roughness(axes[0, 1], data["roughness"], "before_v", "Mean rectified signal, as in the paper")
        _draw_roughness(axes[0, 2], data["roughness"], "after_v", "Roughness, normalised by speed and force")
        _draw_grooves(axes[1, 0], data["grooves"], "speed_mm_s", 1.0, "speed (mm/s)")
        _draw_grooves(axes[1, 1], data["grooves"], "groove_depth_m", 1e6, "depth of grooves (µm)")
        _draw_grooves(axes[1, 2], data["grooves"], "noise_v", 1e3, "noise of the sensor (mV)")
        for place, course in zip(axes[2], data["courses"], strict=False):
            _draw_course(place, course)
        _draw_scatter(axes[2, 2], data["scatter"])


def _draw_accuracy(axes: Axes, rows: Rows) -> None:
    for number, method in enumerate(dict.fromkeys(row["method"] for row in rows)):
        mine = where(rows, method=method)
        times_s, share = [row["time_s"] for row in mine], np.array([row["share"] for row in mine])
        around = 100.0 * np.abs([share - [row["low"] for row in mine], [row["high"] for row in mine] - share])
        axes.errorbar(
            times_s, 100.0 * share, around, color=_COLOURS[number], marker=_MARKS[number], capsize=2, label=method
        )
    axes.axhline(97.0, color=GREY, linestyle=":", linewidth=0.8)
    axes.set(xlabel="time stroked (s)", ylabel="surface right (%)", ylim=(0.0, 102.0))
    axes.set_title("Identification of six surfaces", loc="left")
    axes.legend(fontsize=8)


def _draw_roughness(axes: Axes, rows: Rows, which: str, title: str) -> None:
    for number, surface in enumerate(dict.fromkeys(row["surface"] for row in rows)):
        mine = where(rows, surface=surface)
        axes.scatter(
            [row["speed_mm_s"] for row in mine],
            [1e3 * row[which] for row in mine],
            [6.0 + 6.0 * row["force_n"] for row in mine],
            color=_SURFACES[number % 6],
            alpha=0.6,
            linewidths=0.0,
            label=shown_name(surface),
        )
    log_axes(axes, y=_MILLIVOLTS)
    axes.set(xlabel="speed (mm/s); larger dots: more force", ylabel="mV")
    axes.set_title(title, loc="left")
    if which == "after_v":
        axes.legend(fontsize=7)


def _draw_grooves(axes: Axes, rows: Rows, what: str, unit: float, label: str) -> None:
    for number, method in enumerate(dict.fromkeys(row["method"] for row in rows)):
        mine = where(rows, against=what, method=method)
        values = [unit * row["value"] for row in mine]
        for part, line in (("missed", "-"), ("invented", "--")):
            share = [100.0 * row[part] / max(row["crossed"], 1) for row in mine]
            axes.plot(values, share, line, color=_COLOURS[number], marker=_MARKS[number], label=f"{part}, {method}")
    if what != "speed_mm_s":
        log_axes(axes, sorted({unit * row["value"] for row in rows if row["against"] == what}))
    axes.set_yscale("symlog", linthresh=1.0)
    plain_ticks(axes.yaxis, (0, 1, 10, 100))
    axes.set(ylim=(-0.05, 150.0), xlabel=label, ylabel="of the grooves crossed (%)")
    axes.set_title(f"Grooves against {label.partition(' (')[0]}", loc="left")
    if what == "speed_mm_s":
        axes.legend(fontsize=8)


def _draw_course(axes: Axes, course: Mapping[str, Any]) -> None:
    after_s, held = np.array(course["after_border_s"]), np.array(course["held"])
    axes.fill_between(after_s, 0, 1, where=held, transform=axes.get_xaxis_transform(), color=PALE, label="paper: held")
    axes.plot(after_s, 1e3 * np.array(course["paper_v"]), color=RED, label="paper: mean of the stroke")
    shipped = np.array([np.nan if value is None else value for value in course["shipped_v"]])
    axes.plot(after_s, 1e3 * shipped, color=BLUE, label="shipped: roughness")
    axes.axvline(0.0, color=GREY, linestyle=":", linewidth=0.8)
    log_axes(axes, y=_MILLIVOLTS)
    axes.set(xlabel="since the border was crossed (s)", ylabel="mV")
    axes.set_title(f"{shown_name(course['before'])} to {shown_name(course['after'])}", loc="left")
    axes.legend(fontsize=8)


def _draw_scatter(axes: Axes, rows: Rows) -> None:
    surfaces = list(dict.fromkeys(row["surface"] for row in rows))
    for offset, normalised, colour in ((-0.2, False, RED), (0.2, True, BLUE)):
        share = [100.0 * row["scatter"] for row in rows if row["normalised"] is normalised]
        label = "normalised by speed and force" if normalised else "mean rectified signal"
        axes.barh(np.arange(len(surfaces)) + offset, share, 0.38, color=colour, label=label)
    axes.axvline(15.0, color=GREY, linestyle=":", linewidth=0.8)
    axes.set_yticks(range(len(surfaces)), [shown_name(surface) for surface in surfaces], fontsize=8)
    axes.set(xlabel="standard deviation over mean (%)")
    axes.set_title("One surface, any speed and force", loc="left")
    axes.legend(fontsize=8)
