"""Figure of the number of sessions that a machine carries: rates, lateness, processors and age, with their limits."""

from pathlib import Path
from statistics import median
from typing import Any

from matplotlib.axes import Axes

from common.limits import GAP_S
from common.runtime.rate_monitor import HELD
from studies.counting import grouped
from studies.drawing import Data, Rows, curve, figure_file, where
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, PURPLE, RED, plain_ticks
from teletaction.session.demo_files import PROCESSES

_COLOURS = dict(zip(PROCESSES, (GREEN, PURPLE, BLUE, ORANGE), strict=True))
_MARKS = dict(zip(PROCESSES, "^vos", strict=True))
_DECADES = [lead * 10.0**power for power in range(-2, 4) for lead in (1.0, 3.0)]
_FAILS: dict[str, Any] = {"color": RED, "alpha": 0.12, "linewidth": 0.0}


def plot(data: Data, path: Path) -> None:
    """Draw the data that `run` returned, and write the figure as PNG."""
    with figure_file(path, 11.5, 7.0) as figure:
        places = figure.subplots(2, 2)
        _rates(places[0, 0], data["loops"])
        _lateness(places[0, 1], data["loops"])
        _processors(places[1, 0], data)
        _packets(places[1, 1], data["streams"])
        for axes in places.flat:
            plain_ticks(axes.xaxis, [row["sessions"] for row in data["counts"]])
            axes.set_xlabel("one-finger sessions on this machine")


def _rates(axes: Axes, loops: Rows) -> None:
    axes.axhspan(0.0, 100.0 * HELD, label="rate not held", **_FAILS)
    for process, mark in _MARKS.items():
        mine = where(loops, process=process)
        how: dict[str, Any] = {"color": _COLOURS[process], "marker": mark}
        curve(axes, mine, "sessions", "made", (1.0, 100.0), linestyle="none", alpha=0.35, markersize=4, **how)
        _through(axes, mine, "made", 100.0, label=process, **how)
    axes.set(xscale="log", ylim=(0.0, 103.0), ylabel="ticks made, of those wanted (%)")
    axes.set_title("Rate of each loop; lines: middle session", loc="left")
    axes.legend(loc="upper right")


def _lateness(axes: Axes, loops: Rows) -> None:
    sites = [row for row in loops if row.get("off_p99_us")]
    for process in ("remote", "operator"):
        mine = where(sites, process=process)
        how: dict[str, Any] = {"color": _COLOURS[process], "marker": _MARKS[process]}
        _through(axes, mine, "off_p99_us", 1e-3, label=f"{process}, 99 % below", **how)
        _through(axes, mine, "off_p50_us", 1e-3, label=f"{process}, median", linestyle="--", **how)
    top_ms = max([2e-3 * row["off_p99_us"] for row in sites], default=10.0)
    period_ms = 1e3 / min([row["wanted_hz"] for row in sites], default=500.0)
    axes.axhspan(period_ms, max(top_ms, 2.0 * period_ms), label="a tick is missed", **_FAILS)
    axes.set(xscale="log", yscale="log", ylabel="a tick is too late or too early by (ms)")
    plain_ticks(axes.yaxis, _DECADES)
    axes.set_title("Loops of the sites, middle session", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _processors(axes: Axes, data: Data) -> None:
    counts = [row["sessions"] for row in data["counts"]]
    widths = [0.3 * count for count in counts]
    below = [0.0] * len(counts)
    for process in PROCESSES:
        cores = [
            sum(row["core"] for row in data["loops"] if (row["sessions"], row["process"]) == (count, process))
            for count in counts
        ]
        axes.bar(counts, cores, widths, below, color=_COLOURS[process])
        below = [low + more for low, more in zip(below, cores, strict=True)]
    others = [data["processors"] * (row["others"] + row["stolen"]) for row in data["counts"]]
    axes.bar(counts, others, widths, below, color=PALE, edgecolor=GREY, label="others")
    axes.axhline(data["processors"], color=BLACK, linestyle=":", label="all processors")
    axes.axhspan(data["processors"], 1.25 * data["processors"], **_FAILS)
    axes.set(xscale="log", ylim=(0.0, 1.25 * data["processors"]), ylabel="processors used")
    axes.set_title("Processor time; colours as above", loc="left")
    axes.legend(loc="upper right")


def _packets(axes: Axes, streams: Rows) -> None:
    gaps = [row["longest_gap_ms"] for row in streams]
    axes.axhspan(1e3 * GAP_S, max([200.0, *(1.5 * gap for gap in gaps)]), label="gap: safe state", **_FAILS)
    for stream, colour in (("touch", BLUE), ("motion", ORANGE)):
        mine = where(streams, stream=stream)
        how: dict[str, Any] = {"color": colour}
        curve(axes, mine, "sessions", "longest_gap_ms", marker="x", linestyle="none", alpha=0.5, **how)
        _through(axes, mine, "longest_gap_ms", 1.0, marker="x", linestyle=":", label=f"{stream}, longest gap", **how)
        _through(axes, mine, "age_p99_ms", 1.0, marker="s", label=f"{stream}, age, 99 % below", **how)
        _through(axes, mine, "age_p50_ms", 1.0, marker="o", linestyle="--", label=f"{stream}, age, median", **how)
    axes.set(xscale="log", yscale="log", ylabel="ms")
    plain_ticks(axes.yaxis, _DECADES)
    axes.set_title("Packets between the sites; lines: middle session", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _through(axes: Axes, rows: Rows, value: str, scale: float, **how: Any) -> None:
    """Draw a line through the median of all sessions at each number of sessions."""
    found = grouped((row for row in rows if row[value] is not None), "sessions")
    middle = {count: median(scale * row[value] for row in each) for (count,), each in found.items()}
    axes.plot(list(middle), list(middle.values()), **how)
