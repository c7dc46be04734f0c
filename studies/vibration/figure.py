"""Figure of the vibration study: one tap, all taps, impulses of grooves, and felt against wanted intensity."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, RED, STYLE, plain_ticks

_WAYS = {
    "alone": (RED, "o"),
    "compensated": (BLUE, "s"),
    "started early": (GREEN, "^"),
    "limit": (BLACK, "*"),
    "asked": (GREY, "."),
    "rendered": (GREEN, "^"),
}


def plot(data: Mapping[str, Any], path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11.5, 8.5), layout="constrained")
        FigureCanvasAgg(figure)
        (course, taps), (impulses, scales) = figure.subplots(2, 2)
        _draw_course(course, data["courses"])
        _draw_taps(taps, data["taps"])
        _draw_impulses(impulses, data["impulses"])
        _draw_scales(scales, data["scales"])
        figure.savefig(path, dpi=150)


def _draw_course(axes: Axes, rows: list[dict[str, Any]]) -> None:
    asked = next(row for row in rows if row["way"] == "compensated")
    after_ms = 1e3 * (asked["tick_s"] * np.arange(len(asked["asked"])) - asked["contact_s"])
    axes.plot(after_ms, asked["asked"], color=GREY, linestyle="--", drawstyle="steps-post", label="asked for (Eq. 1)")
    for row in rows:
        axes.plot(after_ms + 1e3 * row["tick_s"], row["speed"], color=_WAYS[row["way"]][0], label=row["way"])
    axes.set_xlim(-40.0, 200.0)
    axes.set_ylim(-200.0, 1.1 * max(asked["asked"]))
    axes.set_xlabel("time since contact (ms)")
    axes.set_ylabel("motor speed (rpm)")
    axes.set_title("One tap", loc="left")
    axes.legend()


def _draw_taps(axes: Axes, rows: list[dict[str, Any]]) -> None:
    for way in ("alone", "compensated", "started early", "limit"):
        colour, mark = _WAYS[way]
        mine = [row for row in rows if row["way"] == way]
        axes.plot(
            [row["attack_rpm"] for row in mine],
            [row["peak_intensity_share"] for row in mine],
            color=colour,
            marker=mark,
            ms=5,
            label=_label(way, mine),
        )
    axes.axhspan(0.8, 1.2, color=PALE, zorder=0)
    axes.set_ylim(0.0, 1.35)
    axes.set_xlabel("attack of the tap (rpm)")
    axes.set_ylabel("peak of the felt intensity / wanted")
    axes.set_title("All taps; grey: within a fifth", loc="left")
    axes.legend(loc="center", bbox_to_anchor=(0.5, 0.42))


def _label(way: str, rows: list[dict[str, Any]]) -> str:
    times = [row["near_after_s"] for row in rows]
    if None in times:
        return f"{way}: not always reached"
    return f"{way}: reached after {1e3 * min(times):.0f} to {1e3 * max(times):.0f} ms"


def _draw_impulses(axes: Axes, rows: list[dict[str, Any]]) -> None:
    for way in ("asked", "alone", "compensated", "rendered"):
        colour, mark = _WAYS[way]
        mine = [row for row in rows if row["way"] == way]
        axes.plot(
            [row["rate_hz"] for row in mine],
            [row["depth"] for row in mine],
            color=colour,
            marker=mark,
            ms=5,
            linestyle="--" if way == "asked" else "-",
            label={"rendered": "rendered: folded above 20 Hz"}.get(way, way),
        )
    axes.axhspan(0.0, 0.25, color=PALE, zorder=0)
    axes.axvline(15.0, color=GREY, linestyle=":")
    axes.axvline(20.0, color=GREY, linestyle=":")
    axes.set_xscale("log")
    plain_ticks(axes.xaxis, (2, 4, 6, 10, 15, 20, 30, 40))
    axes.set_ylim(0.0, 0.8)
    axes.set_xlabel("grooves crossed in a second")
    axes.set_ylabel("dip of the speed between grooves / its top")
    axes.set_title("Grooves; grey: a dip too small to be felt", loc="left")
    axes.legend(loc="center left", bbox_to_anchor=(0.02, 0.46))


def _draw_scales(axes: Axes, rows: list[dict[str, Any]]) -> None:
    for scale, colour in (("speed", ORANGE), ("intensity", BLUE)):
        mine = [row for row in rows if row["scale"] == scale]
        axes.plot(
            [row["asked_share"] for row in mine],
            [row["felt_share"] for row in mine],
            color=colour,
            label={"speed": "matched in speed (the paper's)", "intensity": "matched in intensity"}[scale],
        )
    axes.set_xlabel("asked for by Eq. 1 and 2 / most")
    axes.set_ylabel("felt intensity / most")
    axes.set_title("Felt against wanted intensity", loc="left")
    axes.legend()
