"""Figure of a soak: memory of each process over time, with the faults marked."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from studies.drawing import figure_file
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, ORANGE, PALE, PURPLE, RED
from teletaction.session.demo_files import NETWORK, PROCESSES

_COLOURS = dict(zip((*PROCESSES, NETWORK), (ORANGE, PURPLE, BLUE, GREEN, BLACK), strict=True))
_DASHES = dict(zip((*PROCESSES, NETWORK), ("-", "--", "-", "--", "-."), strict=True))
_CALM, _LATCHED, _WRONG = PALE, "#B9DEF3", RED


def plot(data: Mapping[str, Any], path: Path) -> None:
    """Draw the data that `run` returned, and write the figure as PNG."""
    with figure_file(path, 8.0, 4.2) as figure:
        axes = figure.add_subplot()
        for episode in data["episodes"]:
            label, colour = _verdict(episode)
            axes.axvspan(episode["begin_s"], episode["end_s"], color=colour, lw=0, label=label)
        for curve in data["curves"]:
            process = curve["process"]
            how: dict[str, Any] = {"color": _COLOURS[process], "linestyle": _DASHES[process], "label": process}
            axes.plot(curve["time_s"], curve["rss_mib"], **how)
        axes.set_ylim(0.0, 1.15 * max((max(curve["rss_mib"]) for curve in data["curves"]), default=1.0))
        axes.set_xlim(0.0, data["seconds"])
        axes.set(xlabel="time since the session works (s)", ylabel="resident memory (MiB)")
        axes.set_title(_title(data), loc="left")
        first = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        figure.legend(list(first.values()), list(first), loc="outside lower center", ncols=4)


def _verdict(episode: Mapping[str, Any]) -> tuple[str, str]:
    if episode["wrong"]:
        return "fault with a problem", _WRONG
    if episode["latched"]:
        return "fault that latched", _LATCHED
    return "fault", _CALM


def _title(data: Mapping[str, Any]) -> str:
    outcome = f"{len(data['problems'])} problems" if data["problems"] else "all well"
    return f"{data['faults']} random faults, {sum(data['restarts'].values())} restarts: {outcome}"
