"""Figure of the vibration study: one tap, all taps, impulses of grooves, and felt against wanted intensity."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from studies.drawing import Data, Rows, curve, figure_file, log_axes, where
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, RED

_WAYS = {
    "alone": (RED, "o"),
    "compensated": (BLUE, "s"),
    "started early": (GREEN, "^"),
    "limit": (BLACK, "*"),
    "asked": (GREY, "."),
    "rendered": (GREEN, "^"),
}


def plot(data: Data, path: Path) -> None:
    """Draw the data that the study returned, and write the figure as PNG."""
    with figure_file(path, 11.5, 8.5) as figure:
        (course, taps), (impulses, scales) = figure.subplots(2, 2)
        _draw_course(course, data["courses"])
        _draw_taps(taps, data["taps"])
        _draw_impulses(impulses, data["impulses"])
        _draw_scales(scales, data["scales"])


def _draw_course(axes: Axes, rows: Rows) -> None:
    asked = next(row for row in rows if row["way"] == "compensated")
    after_ms = 1e3 * (asked["tick_s"] * np.arange(len(asked["asked"])) - asked["contact_s"])
    axes.plot(after_ms, asked["asked"], color=GREY, linestyle="--", drawstyle="steps-post", label="asked for (Eq. 1)")
    for row in rows:
        axes.plot(after_ms + 1e3 * row["tick_s"], row["speed"], color=_WAYS[row["way"]][0], label=row["way"])
    axes.set(xlim=(-40.0, 200.0), ylim=(-200.0, 1.1 * max(asked["asked"])), xlabel="time since contact (ms)")
    axes.set(ylabel="motor speed (rpm)")
    axes.set_title("One tap", loc="left")
    axes.legend()


def _draw_taps(axes: Axes, rows: Rows) -> None:
    for way in ("alone", "compensated", "started early", "limit"):
        colour, mark = _WAYS[way]
        mine = where(rows, way=way)
        label = _label(way, mine)
        curve(axes, mine, "attack_rpm", "peak_intensity_share", color=colour, marker=mark, ms=5, label=label)
    axes.axhspan(0.8, 1.2, color=PALE, zorder=0)
    axes.set(ylim=(0.0, 1.35), xlabel="attack of the tap (rpm)", ylabel="peak of the felt intensity / wanted")
    axes.set_title("All taps; grey: within a fifth", loc="left")
    axes.legend(loc="center", bbox_to_anchor=(0.5, 0.42))


def _label(way: str, rows: Rows) -> str:
    times = [row["near_after_s"] for row in rows]
    if None in times:
        return f"{way}: not always reached"
    return f"{way}: reached after {1e3 * min(times):.0f} to {1e3 * max(times):.0f} ms"


def _draw_impulses(axes: Axes, rows: Rows) -> None:
    for way in ("asked", "alone", "compensated", "rendered"):
        colour, mark = _WAYS[way]
        mine = where(rows, way=way)
        line = "--" if way == "asked" else "-"
        label = {"rendered": "rendered: folded above 20 Hz"}.get(way, way)
        curve(axes, mine, "rate_hz", "depth", color=colour, marker=mark, ms=5, linestyle=line, label=label)
    axes.axhspan(0.0, 0.25, color=PALE, zorder=0)
    axes.axvline(15.0, color=GREY, linestyle=":")
    axes.axvline(20.0, color=GREY, linestyle=":")
    log_axes(axes, (2, 4, 6, 10, 15, 20, 30, 40))
    axes.set(ylim=(0.0, 0.8), xlabel="grooves crossed in a second", ylabel="dip of the speed between grooves / its top")
    axes.set_title("Grooves; grey: a dip too small to be felt", loc="left")
    axes.legend(loc="center left", bbox_to_anchor=(0.02, 0.46))


def _draw_scales(axes: Axes, rows: Rows) -> None:
    for scale, colour in (("speed", ORANGE), ("intensity", BLUE)):
        mine = where(rows, scale=scale)
        label = {"speed": "matched in speed (the paper's)", "intensity": "matched in intensity"}[scale]
        curve(axes, mine, "asked_share", "felt_share", color=colour, label=label)
    axes.set(xlabel="asked for by Eq. 1 and 2 / most", ylabel="felt intensity / most")
    axes.set_title("Felt against wanted intensity", loc="left")
    axes.legend()
