"""Speed against accuracy on one page: cost and error of each part of the system, beside baselines."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, figure_file, log_axes
from teletaction.plotting.figure_style import BLUE, GREY, absent

_COLUMNS = 3
_MARKS = "osD^vPX<>*"


@dataclass(frozen=True, slots=True)
class Way:
    """One way to do it: its cost and its error in the part's units; `baseline`: it is an alternative to ours."""

    name: str
    cost: float
    error: float
    baseline: bool = True


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the system.

    Attributes:
        title: name of the part, and its task.
        cost, error: meaning of cost and error, with their units.
        ways: all ways, with a cost and an error each.
        powers: the logarithmic axes: "", "x", "y" or "xy".
    """

    title: str
    cost: str
    error: str
    ways: Sequence[Way]
    powers: str = "x"


def overview_rows(parts: Mapping[str, Part | None]) -> list[dict[str, Any]]:
    """A row for each way of each part, with the study that measured it."""
    return [
        {
            "study": study,
            "part": part.title,
            "way": way.name,
            "baseline": way.baseline,
            "cost": way.cost,
            "cost_is": part.cost,
            "error": way.error,
            "error_is": part.error,
        }
        for study, part in parts.items()
        if part is not None
        for way in part.ways
    ]


def plot(parts: Mapping[str, Part | None], path: Path) -> None:
    """Draw the parts as PNG, with a note for each study that was not run."""
    lines = -(-len(parts) // _COLUMNS)
    with figure_file(path, WIDEST_IN, 4.2 * lines) as figure:
        figure.suptitle(
            "Speed against accuracy: further down and to the left is better; ours in blue, baselines hollow"
        )
        places = list(figure.subplots(lines, _COLUMNS, squeeze=False).flat)
        for axes, (study, part) in zip(places, parts.items(), strict=False):
            if part is None:
                axes.set_axis_off()
                absent(axes, f"{study}: not measured")
            else:
                draw(axes, part)
        for axes in places[len(parts) :]:
            axes.set_axis_off()


def draw(axes: Axes, part: Part) -> None:
    """One part: a mark for each way, named in the legend."""
    for mark, way in zip(cycle(_MARKS), part.ways, strict=False):
        colour = GREY if way.baseline else BLUE
        axes.plot(
            [way.cost],
            [way.error],
            marker=mark,
            markersize=7,
            color=colour,
            markerfacecolor="white" if way.baseline else colour,
            linestyle="none",
            clip_on=False,
            zorder=3,
            label=way.name,
        )
    _scale(axes, "x", [way.cost for way in part.ways], "x" in part.powers)
    _scale(axes, "y", [way.error for way in part.ways], "y" in part.powers)
    axes.set(title=part.title, xlabel=part.cost, ylabel=part.error)
    axes.legend(frameon=True, framealpha=0.8, edgecolor="none", fontsize=8)


def _scale(axes: Axes, axis: str, values: Sequence[float], powers: bool) -> None:
    """Scale an axis from 0 to beyond the largest value, with room for the legend, or over the decades of the values."""
    if not powers:
        axes.set(**{f"{axis}lim": (0.0, (1.35 if axis == "y" else 1.15) * max(values) or 1.0)})
        return
    low, high = 0.6 * min(values), 1.8 * max(values)
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [lead * 10.0**power for power in decades for lead in (1.0, 3.0)]
    log_axes(axes, **{axis: [tick for tick in ticks if low <= tick <= high]})
    axes.set(**{f"{axis}lim": (low, high)})
