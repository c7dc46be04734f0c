"""Figure of the stability study: regions, displayed stiffness against delay, stability limits, and energy produced."""

from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from studies.drawing import WIDEST_IN, Data, Rows, figure_file, log_axes, where
from studies.teleoperation_stability.cases import DEVICE_NS_M
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, RED, plain_ticks

WAYS = {
    "direct position-force": (RED, "o"),
    "wave variables": (BLUE, "s"),
    "time-domain passivity": (ORANGE, "^"),
    "local model, blended": (GREY, "v"),
    "local model": (GREEN, "D"),
}
HAND, LINK = "light", "steady"
JND = 0.23
_COLOURS = ("#FFFFFF", "#F3C9A5", RED)
_LEVELS = ListedColormap(_COLOURS)


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    shortest = min(row["period_ms"] for row in data["matrix"])
    rows = where(data["matrix"], period_ms=shortest)
    with figure_file(path, WIDEST_IN, 11.5) as figure:
        axes = figure.subplots(3, 3)
        cap_n_m = 2.0 * DEVICE_NS_M / (1e-3 * shortest)
        for each, name in zip(axes.flat, WAYS, strict=False):
            _draw_region(each, name, rows, data["borders"], cap_n_m)
        key, accuracy, energy, borders = axes.flat[5:]
        key.set_axis_off()
        title = "Each cell: one wall and one delay,\nlight hand, steady link"
        key.legend(handles=_region_keys(cap_n_m), loc="center left", title=title, alignment="left")
        _draw_accuracy(accuracy, rows)
        _draw_energy(energy, data["matrix"])
        _draw_borders(borders, data["borders"])


def _draw_region(axes: Axes, name: str, rows: Rows, borders: Rows, cap_n_m: float) -> None:
    """Draw white for rest and at most 1 mJ, pale for more than 1 mJ, and red for oscillation that lasts.

    A map without oscillation says so, since empty cells look like missing data.
    """
    mine = where(rows, architecture=name, hand=HAND, link=LINK)
    trips = sorted({row["round_trip_ms"] for row in mine})
    walls = sorted({row["wall_n_m"] for row in mine})
    level = np.zeros((len(walls), len(trips)))
    for row in mine:
        at = walls.index(row["wall_n_m"]), trips.index(row["round_trip_ms"])
        level[at] = 2.0 if not row["stable"] else float(row["produced_mj"] > 1.0)
    axes.pcolormesh(
        np.arange(len(trips) + 1) - 0.5, _edges(walls), level, cmap=_LEVELS, vmin=0.0, vmax=2.0, edgecolors="#DDDDDD"
    )
    if level.max() < 2.0:
        text = "stable everywhere" + ("" if level.any() else ",\nat most 1 mJ")
        box = {"facecolor": "white", "edgecolor": GREEN, "boxstyle": "round,pad=0.4"}
        axes.text(0.5, 0.3, text, transform=axes.transAxes, ha="center", va="center", fontsize=11, bbox=box)
    border = [b for b in borders if b["hand"] == HAND and b["round_trip_ms"] in trips and b["worked_out_n_m"]]
    if name == "direct position-force":
        axes.plot(
            [trips.index(b["round_trip_ms"]) for b in border],
            [b["worked_out_n_m"] for b in border],
            color=BLACK,
            marker=".",
        )
    elif name == "local model":
        axes.axhline(cap_n_m, color=BLACK, linestyle="--")
    axes.set_xticks(range(len(trips)), [f"{trip:g}" for trip in trips])
    log_axes(axes, y=walls)
    axes.grid(False)
    axes.set(xlabel="round trip (ms)", ylabel="wall (N/m)")
    axes.set_title(name, loc="left")


def _region_keys(cap_n_m: float) -> list[Artist]:
    names = ("comes to rest, at most 1 mJ produced", "comes to rest, more than 1 mJ produced", "oscillates")
    cells = [Patch(facecolor=colour, edgecolor=GREY, label=name) for colour, name in zip(_COLOURS, names, strict=True)]
    return [
        *cells,
        Line2D([], [], color=BLACK, marker=".", label="largest stable wall, calculated"),
        Line2D([], [], color=BLACK, linestyle="--", label=f"displayed no stiffer than {cap_n_m:g} N/m"),
    ]


def _edges(walls: list[float]) -> list[float]:
    middles = [(a * b) ** 0.5 for a, b in pairwise(walls)]
    return [walls[0] ** 2 / middles[0], *middles, walls[-1] ** 2 / middles[-1]]


def _draw_accuracy(axes: Axes, rows: Rows) -> None:
    walls = sorted({row["wall_n_m"] for row in rows})
    shown = min(walls, key=lambda wall: abs(wall - 500.0))
    for name, (colour, mark) in WAYS.items():
        mine = where(rows, architecture=name, hand=HAND, link=LINK, wall_n_m=shown)
        errors = [row["felt_n_m"] / shown - 1.0 if row["stable"] and row["felt_n_m"] else np.nan for row in mine]
        axes.plot([row["round_trip_ms"] for row in mine], errors, color=colour, marker=mark, ms=5, label=name)
    axes.axhspan(-JND, JND, color=PALE, zorder=0)
    axes.set_xscale("symlog", linthresh=10.0)
    plain_ticks(axes.xaxis, (0, 10, 20, 50, 100, 200, 400))
    axes.set(ylim=(-1.0, 0.5), xlabel="round trip (ms)", ylabel="error of the displayed stiffness")
    axes.set_title(f"Wall of {shown:g} N/m; grey: below JND (23 %);\nno mark: oscillates", loc="left")
    axes.legend(fontsize=7.5)


def _draw_energy(axes: Axes, rows: Rows) -> None:
    for name, (colour, _) in WAYS.items():
        most = np.sort([max(1e-3, row["produced_mj"]) for row in rows if row["architecture"] == name])
        axes.plot(most, np.arange(1, len(most) + 1) / len(most), color=colour, drawstyle="steps-post", label=name)
    axes.axvline(1.0, color=BLACK, linestyle=":")
    log_axes(axes, (0.01, 0.1, 1, 10, 100, 1000))
    axes.set(ylim=(0.0, 1.02), xlabel="energy produced at the operator (mJ)", ylabel="share of all runs")
    axes.set_title("All runs; dotted: 1 mJ", loc="left")


def _draw_borders(axes: Axes, borders: Rows) -> None:
    for hand, colour in zip(dict.fromkeys(row["hand"] for row in borders), (RED, BLUE, GREEN), strict=False):
        mine = where(borders, hand=hand)
        trips = [row["round_trip_ms"] for row in mine]
        axes.plot(trips, [row["worked_out_n_m"] or np.nan for row in mine], color=colour, label=hand)
        axes.plot(trips, [row["simulated_n_m"] or np.nan for row in mine], color=colour, linestyle="", marker="o", ms=5)
    axes.set_xscale("symlog", linthresh=10.0)
    axes.set_yscale("log")
    plain_ticks(axes.xaxis, (0, 10, 20, 50, 100, 200, 400))
    plain_ticks(axes.yaxis, (100, 200, 500, 1000, 2000))
    axes.set(xlabel="round trip (ms)", ylabel="largest stable wall (N/m)")
    axes.set_title("Direct position-force:\nlines calculated, dots simulated", loc="left")
    axes.legend()
