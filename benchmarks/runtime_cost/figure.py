"""The figure of what ticks cost: by stage at five fingers, and by the number of fingers."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.runtime_cost.measure import DOING, TICK
from teletaction.figure_style import BLUE, GREEN, GREY, ORANGE, PALE, PURPLE, RED, STYLE

Rows = Sequence[Mapping[str, Any]]
SITES = ("remote", "operator")
PROCESSES = (*SITES, "sim-remote", "sim-operator")
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED, "#8c6d46", "#5f9ea0", "#b0a040", PALE)


def plot(data: Mapping[str, Any], path: Path) -> None:
    """Write the figure of what `run` returned as PNG."""
    rows = data["cost"]
    most = max(row["fingers"] for row in rows)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11.5, 7.5), layout="constrained")
        FigureCanvasAgg(figure)
        places = figure.subplots(2, 2)
        for axes, site in zip(places[0], SITES, strict=True):
            _stages(axes, [row for row in rows if row["process"] == site and row["fingers"] == most])
            axes.set_title(f"{site} site, {most} fingers, by stage", loc="left")
        for axes, doing in zip(places[1], ("free", "resting"), strict=True):
            _fingers(axes, [row for row in rows if row["doing"] == doing and row["stage"] == TICK])
            axes.set_title(f"all processes, fingers {doing}", loc="left")
        figure.suptitle(f"One reference step is {data['reference_step_us']:.0f} us here", x=0.01, ha="left")
        figure.savefig(path, dpi=150)


def _stages(axes: Axes, rows: Rows) -> None:
    cost = {(row["doing"], row["stage"]): row["reference_steps"] for row in rows}
    stages = sorted({stage for _, stage in cost} - {TICK}, key=lambda stage: -cost.get(("stroking", stage), 0.0))
    bottom = [0.0] * len(DOING)
    for stage, colour in zip(stages, _COLOURS, strict=False):
        heights = [cost.get((doing, stage), 0.0) for doing in DOING]
        axes.bar(DOING, heights, 0.6, bottom, color=colour, label=stage)
        bottom = [below + height for below, height in zip(bottom, heights, strict=True)]
    rest = [max(0.0, cost.get((doing, TICK), 0.0) - below) for doing, below in zip(DOING, bottom, strict=True)]
    axes.bar(DOING, rest, 0.6, bottom, color=GREY, label="between stages")
    axes.set_ylabel("cost of a tick, mean (reference steps)")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)


def _fingers(axes: Axes, rows: Rows) -> None:
    for process, colour in zip(PROCESSES, (BLUE, ORANGE, GREEN, PURPLE), strict=True):
        mine = sorted((row["fingers"], row["reference_steps"]) for row in rows if row["process"] == process)
        axes.plot(*zip(*mine, strict=True), "o-", color=colour, label=process)
    axes.set_ylim(bottom=0.0)
    axes.set_xticks(sorted({row["fingers"] for row in rows}))
    axes.set(xlabel="fingers", ylabel="cost of a tick, mean (reference steps)")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)
