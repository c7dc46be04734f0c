"""Figure of the recorded presses: prediction by method, bars, and what is shown of liver."""

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import WIDEST_IN, Data, draw_panels, where
from teletaction.plotting.figure_style import BLUE, GREEN, GREY, ORANGE

_METHODS = {"learned prior": BLUE, "Hertz": ORANGE, "line": GREY}
_WAYS = {"tangent of the law": BLUE, "live, one motion": ORANGE, "live, steps": GREY}
_REACHED = {"ambitious": GREEN, "honest": BLUE, None: ORANGE}


def plot(data: Data, path: Path) -> None:
    """Draw the study's data as PNG."""
    panels = ((draw_prediction, draw_shown, draw_bars),)
    draw_panels(data, path, (WIDEST_IN, 5.0), panels, width_ratios=(1.0, 1.0, 1.3))


def draw_prediction(axes: Axes, data: Data) -> None:
    """Draw the share of predicted samples within each error, for each material and method."""
    for material, style in zip(("silicone", "meat", "liver"), ("-", "--", ":"), strict=True):
        for method, colour in _METHODS.items():
            for row in where(data["errors"], material=material, method=method):
                label = material if method == "learned prior" else None
                axes.plot(100.0 * np.array(row["percentiles"]), range(101), style, color=colour, label=label)
    axes.set(xlim=(0.0, 60.0), xlabel="error of the force (%)", ylabel="predicted samples (%)")
    axes.set_title("Deepest three of ten steps")
    key = axes.legend(title="blue: learned prior\norange: Hertz, grey: line", loc="lower right", fontsize="small")
    key.get_title().set_fontsize("small")


def draw_shown(axes: Axes, data: Data) -> None:
    """Draw the share of presses that are shown too hard."""
    sets = list(dict.fromkeys(row["set"] for row in data["shown"]))
    for k, (way, colour) in enumerate(_WAYS.items()):
        rows = where(data["shown"], way=way)
        places = np.arange(len(sets)) + 0.27 * (k - 1)
        axes.bar(places, [100.0 * row["too_hard"] for row in rows], 0.25, color=colour, label=way)
    axes.axhline(20.0, color=GREY, linestyle=":")
    axes.set(xticks=range(len(sets)), xticklabels=sets, ylim=(0.0, 100.0), ylabel="presses (%)")
    axes.set_title("Shown more than 0.1 N too hard")
    axes.legend(loc="upper right", fontsize="small")


def draw_bars(axes: Axes, data: Data) -> None:
    """Draw each bar's value as a fraction of its honest limit, coloured by what it reaches."""
    rows = data["bars"][::-1]
    for k, row in enumerate(rows):
        least = row["honest_to"] >= 1.0
        limit = row["honest_from"] if least else row["honest_to"]
        fraction = row["value"] / limit if limit else math.inf if row["value"] > 0.0 else 0.0
        axes.barh(k, min(fraction, 3.9), color=_REACHED[row["reached"]])
        sign = "at least" if least else "at most"
        axes.text(3.95, k, f"{row['value']:.3f}, {sign} {limit:g}", va="center", ha="right", fontsize="x-small")
    axes.axvline(1.0, color=GREY, linestyle=":")
    labels = [f"{row['bar']}, {row['of']}" for row in rows]
    axes.set_yticks(range(len(rows)), labels, fontsize="x-small")
    axes.set(xlim=(0.0, 4.0), xlabel="value over the honest bar")
    axes.set_title("Bars: green ambitious, blue honest")
