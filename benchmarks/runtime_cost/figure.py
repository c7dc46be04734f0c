"""Figure of the runtime cost: cost of a tick by stage and by number of fingers, and accuracy by cost."""

from itertools import pairwise
from pathlib import Path

from matplotlib.axes import Axes

from benchmarks.runtime_cost.accuracy import END_S, LATE, PRODUCT
from benchmarks.runtime_cost.measure import DOING, TICK
from studies.drawing import Data, Rows, figure_file, stacked_bars, where
from teletaction.plotting.figure_style import BLUE, GREEN, GREY, ORANGE, PALE, PURPLE, RED, plain_ticks

SITES = ("remote", "operator")
PROCESSES = (*SITES, "sim-remote", "sim-operator")
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED, "#8c6d46", "#5f9ea0", "#b0a040", PALE)


def plot(data: Data, path: Path) -> None:
    """Draw the data that `run` returned, and write the figure as PNG."""
    rows = data["cost"]
    most = max(row["fingers"] for row in rows)
    with figure_file(path, 11.5, 11.0) as figure:
        places = figure.subplots(3, 2)
        for axes, site in zip(places[0], SITES, strict=True):
            _stages(axes, where(rows, process=site, fingers=most))
            axes.set_title(f"{site} site, {most} fingers, by stage", loc="left")
        for axes, doing in zip(places[1], ("free", "resting"), strict=True):
            _fingers(axes, where(rows, doing=doing, stage=TICK))
            axes.set_title(f"all processes, fingers {doing}", loc="left")
        _names(places[2, 0], data["accuracy"])
        _times(places[2, 1], data["accuracy"])
        figure.suptitle(f"One reference step is {data['reference_step_us']:.0f} us here", x=0.01, ha="left")


def _stages(axes: Axes, rows: Rows) -> None:
    cost = {(row["doing"], row["stage"]): row["reference_steps"] for row in rows}
    stages = sorted({stage for _, stage in cost} - {TICK}, key=lambda stage: -cost.get(("stroking", stage), 0.0))
    parts = {
        stage: ([cost.get((doing, stage), 0.0) for doing in DOING], colour)
        for stage, colour in zip(stages, _COLOURS, strict=False)
    }
    tops = stacked_bars(axes, DOING, parts, 0.6)
    rest = [max(0.0, cost.get((doing, TICK), 0.0) - top) for doing, top in zip(DOING, tops, strict=True)]
    axes.bar(DOING, rest, 0.6, tops, color=GREY, label="between stages")
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


def _names(axes: Axes, rows: Rows) -> None:
    cost = [row["reference_steps"] for row in rows]
    for kind, colour in (("right", BLUE), ("wrong", RED)):
        shares = [row[kind] for row in rows]
        ends = [
            [abs(row[f"{kind}_{end}"] - share) for row, share in zip(rows, shares, strict=True)]
            for end in ("low", "high")
        ]
        axes.errorbar(cost, shares, ends, fmt="o-", capsize=2.0, color=colour, label=f"named {kind}ly (95 %)")
    axes.set(ylim=(-0.02, 1.02), ylabel=f"share of touches, after {END_S:g} s")
    _budget(axes, rows)
    axes.set_title("identification by its cost: names", loc="left")


def _times(axes: Axes, rows: Rows) -> None:
    cost = [row["reference_steps"] for row in rows]
    for column, label, style in (("named_s", "median", "o-"), ("named_p90_s", "90 %", "^--")):
        axes.plot(cost, [row[column] for row in rows], style, color=BLUE, label=f"time to name rightly, {label}")
    errors_k = [row["object_rms_k"] for row in rows]
    axes.plot(cost, errors_k, "s-", color=ORANGE, label="object's temperature, rms error (K)")
    axes.set(ylim=(0.0, END_S), ylabel="time to name (s), error (K)")
    _budget(axes, rows)
    axes.set_title("identification by its cost: time and temperature", loc="left")


def _budget(axes: Axes, rows: Rows) -> None:
    """Draw the axis of cost, the costs of the product's schedules, and the costs at which identification fails."""
    axes.set_xscale("log")
    cost = [row["reference_steps"] for row in rows]
    plain_ticks(axes.xaxis, (0.5, 1.0, 2.0, 5.0, 10.0, 20.0))
    between = [cost[0] * 1.2, *((one * other) ** 0.5 for one, other in pairwise(cost)), cost[-1] / 1.2]
    axes.set_xlim(between[-1], between[0])
    label = "fails"
    for row, (high, low) in zip(rows, pairwise(between), strict=True):
        if row["fails"]:
            axes.axvspan(low, high, color=PALE, zorder=0, linewidth=0.0, label=label)
            label = ""
        if (style := {PRODUCT: "--", LATE: ":"}.get(row["schedule"])) is not None:
            axes.axvline(row["reference_steps"], color=GREY, linestyle=style, label=row["schedule"])
    axes.set_xlabel("cost of a reading of five fingers, 10 ms (reference steps)")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8)
