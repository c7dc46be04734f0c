"""Figure of the study of the kinesthetic loop: lateness, cost, and time from height to force."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import Data, Rows, figure_file, log_axes, stacked_bars
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED

_COLOURS = {"bare loop": BLACK, "virtual": BLUE, "socketcand": RED}
_PARTS = {"contacts": GREEN, "limits": ORANGE, "decode": BLUE, "encode": PURPLE, "bus": GREY}
_SHARES = np.linspace(0.0, 1.0, 201)


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    with figure_file(path, 11.5, 4.2) as figure:
        late, step, answers = figure.subplots(1, 3)
        _draw_late(late, data["loops"])
        _draw_step(step, data["loops"], data["budget"])
        _draw_answers(answers, data["answers"])


def _style(row: Mapping[str, Any]) -> dict[str, Any]:
    rate_hz = row["rate_hz"]
    return {
        "color": _COLOURS[row["bus"]],
        "linestyle": "-" if rate_hz == 1000.0 else ":",
        "label": f"{row['bus']}, {rate_hz:g} Hz",
    }


def _draw_late(axes: Axes, rows: Rows) -> None:
    for row in rows:
        axes.plot(row["late_us"], _SHARES, **_style(row))
    log_axes(axes, (1, 10, 100, 1000, 10_000))
    axes.set(xlabel="tick is late by, µs", ylabel="share of ticks", title="Lateness")
    axes.legend()


def _draw_step(axes: Axes, loops: Rows, budget: float) -> None:
    rows, bare = [row for row in loops if "bus_us" in row], [row for row in loops if "bus_us" not in row]
    names = [f"{row['bus']}\n{row['rate_hz']:g}" for row in rows]
    parts = {part: ([row[f"{part}_us"] for row in rows], colour) for part, colour in _PARTS.items()}
    tops = stacked_bars(axes, names, parts)
    axes.axhline(budget * 1e3, color=RED, linestyle="--", label=f"{budget:.0%} of 1 ms")
    axes.axhline(bare[0]["step_us"], color=BLACK, linestyle=":", label="bare springs")
    axes.set(ylabel="median cost, µs", title="One tick of five fingers", ylim=(0.0, 1.7 * float(tops.max())))
    axes.legend(ncols=2)


def _draw_answers(axes: Axes, rows: Rows) -> None:
    for row in rows:
        axes.plot(row["took_ms"], _SHARES, **_style(row))
    log_axes(axes, (0.1, 0.3, 1, 3, 10, 30))
    axes.set(xlabel="ms", ylabel="share of answers", title="From height measured to force there")
    axes.legend()
