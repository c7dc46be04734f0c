"""Figure of the cost of consoles: lateness of the operator's loop in each way, and memory of the console."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import Data, figure_file
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, plain_ticks

_COLOURS = (BLACK, GREY, ORANGE, BLUE, BLACK, GREY, BLUE)
_DASHES = (*4 * ("-",), *3 * ((0, (4, 1)),))


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    with figure_file(path, 9.0, 3.8) as figure:
        late, memory = figure.subplots(1, 2)
        _plot_late(late, data)
        _plot_memory(memory, data)
        figure.legend(*late.get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _plot_late(axes: Axes, data: Data) -> None:
    # The ways with ordinary priority are missing where the loop has no real-time priority.
    for (way, off_us), colour, dash in zip(data["off_us"].items(), _COLOURS, _DASHES, strict=False):
        rarer = 1.0 - np.linspace(0.0, 1.0, len(off_us))
        axes.loglog(np.maximum(off_us, 1.0)[:-1], rarer[:-1], color=colour, linestyle=dash, label=way)
    plain_ticks(axes.xaxis, (1, 10, 100, 1000))
    plain_ticks(axes.yaxis, (0.01, 0.1, 1))
    axes.set(xlabel="period error of a tick, late or early (us)", ylabel="share of ticks with a larger error")
    axes.set_title(f"Operator's loop, period {data['period_ms']:g} ms", loc="left")


def _plot_memory(axes: Axes, data: Data) -> None:
    curve = data["memory_curve"]
    axes.plot(np.array(curve["time_s"]) / 60.0, curve["rss_mib"], color=GREEN)
    axes.set_ylim(0.0, 1.25 * max(curve["rss_mib"]))
    axes.set(xlabel="time since the console was started (min)", ylabel="resident memory of the console (MiB)")
    pictures = data["page"]["pictures_per_s"]
    axes.set_title(f"Five pages, {min(pictures):.0f} pictures/s each or more", loc="left")
