"""The figures of a session: each one a `Figure` of its own, or None where the recording has nothing for it.

Only matplotlib's objects are used, never pyplot: nothing is left behind in the process.
"""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from common.fingers import FINGERS
from common.limits import CONTACT_FORCE_N, FINGER_FORCE_N
from common.messages import ThermalStatus
from teletaction.figure_style import (
    BLACK,
    BLUE,
    FINGER_COLOURS,
    FINGER_DASHES,
    finger_keys,
    label_once,
    mode_keys,
    shown_name,
    status_keys,
)
from teletaction.finger_panels import (
    ANSWERING,
    draw_comfort,
    draw_force,
    draw_materials,
    draw_modes,
    draw_object_c,
    draw_objects,
    draw_probability,
    draw_temperature,
    draw_vibration,
)
from teletaction.session_curves import SHORTEST_TOUCH_S, SessionCurves, SharedTouch
from teletaction.session_data import Floats

WIDTH_IN = 11.5
MOST_TOUCHES = 12
"""Touches shown converging; the table has them all."""
_TIME = "time since both sites engaged (s)"
_ROW_IN = 1.12
_LABELS = (
    "mode",
    "vibration\n(rpm)",
    "plate and\nskin (°C)",
    "likeliest\nmaterial",
    "probability",
    "object (°C)",
    "force (N)",
)


def session_figure(session: SessionCurves, finger: int) -> Figure:
    """One finger over the whole session in seven panels, 16 x 10 inches."""
    figure = Figure(figsize=(16, 10))
    grid = {"left": 0.1, "right": 0.795, "top": 0.925, "bottom": 0.055, "hspace": 0.16}
    heights = (0.62, 1.0, 1.25, 1.25, 0.75, 1.05, 0.9)
    panels = figure.subplots(7, 1, sharex=True, height_ratios=heights, gridspec_kw=grid)
    figure.suptitle(f"One session, {FINGERS[finger]} finger: what was touched, identified, shown and felt",
                    x=0.1, y=0.985, ha="left", fontsize=13, fontweight="bold")  # fmt: skip
    modes, vibration, temperature, materials, probability, object_c, force = panels
    draw_modes(modes, session, (finger,), ("",) * len(FINGERS))
    draw_objects(modes, session, (finger,))
    draw_vibration(vibration, session, finger)
    draw_temperature(temperature, session, finger)
    draw_materials(materials, session, finger)
    draw_probability(probability, session, finger)
    draw_object_c(object_c, session, finger)
    draw_force(force, session, finger)
    units = (
        "mode",
        "vibration\n(rpm)",
        "plate and\nskin (°C)",
        "likeliest\nmaterial",
        "probability",
        "object (°C)",
        "force (N)",
    )
    for axes, unit in zip(panels, units, strict=True):
        axes.set_ylabel(unit)
    figure.align_ylabels(list(panels))
    aside = {"loc": "center left", "bbox_to_anchor": (1.005, 0.5), "borderaxespad": 0.0, "handlelength": 1.6}
    modes.legend(handles=mode_keys(), **aside, ncols=2, columnspacing=1.0)
    materials.legend(handles=[Line2D([], [], color=BLACK, marker="s", markerfacecolor="none", linestyle="none",
                                     label="true material"), *status_keys()], **aside)  # fmt: skip
    for axes in (vibration, temperature, object_c, force):
        label_once(axes, **aside)
    _end_time_axis(panels[-1], session)
    return figure


def modes_figure(session: SessionCurves) -> Figure | None:
    """True above identified mode of every finger."""
    if _nothing(session, ("contact", "mode"), ("touch", "mode")):
        return None
    figure = Figure(figsize=(WIDTH_IN, 1.5 + 0.62 * len(session.fingers)))
    margins = _Margins(figure, top_in=0.85)
    axes = figure.subplots(gridspec_kw=margins.grid)
    draw_modes(axes, session, session.fingers, FINGERS)
    draw_objects(axes, session, session.fingers)
    margins.legend(mode_keys())
    _end_time_axis(axes, session)
    return figure


def vibration_figure(session: SessionCurves) -> Figure | None:
    """Motor speed at each module, a row a finger."""
    if _nothing(session, ("rendered", "motor_rpm"), ("fingertips", "motor_rpm")):
        return None
    return _rows(session, draw_vibration, "rpm")


def temperature_figure(session: SessionCurves) -> Figure | None:
    """Plate and skin temperatures, a row a finger."""
    if _nothing(session, ("rendered", "plate_set_c"), ("fingertips", "plate_c"), ("skin", "felt_c")):
        return None

    def draw(axes: Axes, session: SessionCurves, finger: int) -> None:
        draw_temperature(axes, session, finger)
        draw_comfort(axes)

    return _rows(session, draw, "°C", row_in=1.35)


def force_figure(session: SessionCurves) -> Figure | None:
    """Forces, a row a finger, and beside them the largest of each against its limit."""
    if _nothing(session, ("fingertips", "force_n"), ("contact", "force_n"), ("touch", "contact_force_n")):
        return None
    figure = _rows(session, draw_force, "N", right_in=3.3)
    largest = figure.add_axes((1 - 2.3 / WIDTH_IN, 0.0, 2.15 / WIDTH_IN, 1.0))
    spot = figure.axes[0].get_position()
    bottom = figure.axes[len(session.fingers) - 1].get_position()
    largest.set_position((1 - 2.3 / WIDTH_IN, bottom.y0, 2.15 / WIDTH_IN, spot.y1 - bottom.y0))
    for row, finger in enumerate(session.fingers):
        for series, shift, colour, limit_n in (
            (session.data.contact, 0.2, BLACK, CONTACT_FORCE_N),
            (session.data.fingertips, -0.2, BLUE, FINGER_FORCE_N),
        ):
            curve = session.curve(series, "force_n", finger)
            peak_n = 0.0 if curve is None else float(np.nanmax(curve.value))
            largest.barh(-row + shift, peak_n, height=0.34, color=colour)
            largest.plot([limit_n] * 2, [-row + shift - 0.2, -row + shift + 0.2], color=colour, linewidth=2.5)
            largest.text(peak_n + 0.15, -row + shift, f"{peak_n:.2f}", va="center", fontsize=8)
    largest.set_yticks([-row for row in range(len(session.fingers))], [FINGERS[f] for f in session.fingers])
    largest.set_ylim(-len(session.fingers) + 0.45, 0.55)
    largest.set_xlim(0, 1.08 * FINGER_FORCE_N)
    largest.set_xlabel("largest (bar) and limit (line), N")
    largest.grid(visible=False, axis="y")
    return figure


def convergence_figure(session: SessionCurves) -> Figure | None:
    """Probability and object temperature since contact, a pair of panels for each touched object."""
    shared = [
        touch
        for touch in session.shared_touches(session.fingers, SHORTEST_TOUCH_S)
        if any(_known(session, touch, "probability"))
    ][:MOST_TOUCHES]
    if not shared:
        return None
    columns = min(4, len(shared))
    rows = math.ceil(len(shared) / columns)
    figure = Figure(figsize=(WIDTH_IN, 0.6 + 3.7 * rows))
    margins = _Margins(figure, top_in=0.95, between_in=1.1, rows=rows)
    outer = figure.add_gridspec(rows, columns, **margins.grid, wspace=0.24)
    for place, touch in enumerate(shared):
        pair = outer[place // columns, place % columns].subgridspec(2, 1, hspace=0.1)
        upper = figure.add_subplot(pair[0])
        lower = figure.add_subplot(pair[1], sharex=upper)
        _draw_converging(session, touch, upper, lower)
        if place % columns == 0:
            upper.set_ylabel("probability")
            lower.set_ylabel("object (°C)")
        lower.set_xlabel("s since contact")
    keys = [*finger_keys(session.fingers, FINGERS),
            Line2D([], [], color=BLACK, linewidth=2.4, label="true temperature"),
            Line2D([], [], color=BLACK, marker="o", linestyle="none", label="named here")]  # fmt: skip
    margins.legend(keys)
    return figure


def _draw_converging(session: SessionCurves, shared: SharedTouch, upper: Axes, lower: Axes) -> None:
    said: Counter[str] = Counter()
    seen = [t.object_c for t in shared.touches if np.isfinite(t.object_c)]
    longest_s = max(t.end_s - t.start_s for t in shared.touches)
    for touch in shared.touches:
        answers = [a for a in session.answers(touch) if a.get("best")]
        colour = FINGER_COLOURS[touch.finger]
        how: dict[str, Any] = {"color": colour, "linestyle": FINGER_DASHES[touch.finger], "linewidth": 1.3}
        time_s = np.array([a["time_s"] for a in answers])
        upper.plot(time_s, [a["probability"] for a in answers], **how)
        named = next((a for a in answers if a["status"] == ThermalStatus.IDENTIFIED), None)
        if named is not None:
            upper.plot(named["time_s"], named["probability"], "o", color=colour, markersize=5)
        said[_said(answers)] += 1
        mean, deviation = (_while_answering(answers, name) for name in ("object_c", "object_c_sd"))
        lower.fill_between(time_s, mean - deviation, mean + deviation, color=colour, alpha=0.12, linewidth=0)
        lower.plot(time_s, mean, **how)
        told_c = mean[np.isfinite(mean)]
        seen += np.percentile(told_c, (10, 90)).tolist() if len(told_c) > 2 else []
        lower.plot([0, longest_s], [touch.object_c] * 2, color=BLACK, linewidth=2.4, zorder=1.5)
    true = ", ".join(dict.fromkeys(t.material for t in shared.touches))
    told = ", ".join(f"{count} × {what}" for what, count in said.most_common())
    title: dict[str, Any] = {"loc": "left", "fontsize": 9.0, "fontweight": "bold", "pad": 30}
    upper.set_title(_fitted(f"{shared.thing}, at {shared.start_s:.0f} s"), **title)
    upper.annotate(f"{_fitted('true: ' + true)}\n{_fitted('told: ' + told)}", (0, 1), xytext=(0, 4), fontsize=8.5,
                   xycoords="axes fraction", textcoords="offset points")  # fmt: skip
    upper.set_ylim(-0.04, 1.08)
    upper.set_yticks([0, 0.5, 1])
    upper.tick_params(labelbottom=False)
    upper.set_xlim(0, max(longest_s, 1.0))
    if seen:
        lower.set_ylim(min(seen) - 2.0, max(seen) + 2.0)


def _said(answers: list[dict[str, Any]]) -> str:
    if not answers:
        return "no answer"
    last = answers[-1]
    status = ThermalStatus(last["status"])
    return str(last["best"]) if status is ThermalStatus.IDENTIFIED else status.name.lower()


def _while_answering(answers: list[dict[str, Any]], name: str) -> Floats:
    values = [a[name] if a["status"] in ANSWERING and a[name] is not None else np.nan for a in answers]
    return np.array(values, dtype=np.float64)


def _fitted(text: str) -> str:
    """As much of a line as fits above a narrow panel."""
    return shown_name(text, 34)


def _known(session: SessionCurves, shared: SharedTouch, name: str) -> list[bool]:
    return [a.get(name) is not None and a.get("best") is not None for t in shared.touches for a in session.answers(t)]


class _Margins:
    """Margins in inches, which a figure of any height keeps, and the legend in the upper one."""

    def __init__(self, figure: Figure, top_in: float = 0.4, right_in: float = 0.15, between_in: float = 0.12,
                 rows: int = 1) -> None:  # fmt: skip
        width_in, height_in = figure.get_size_inches()
        self._figure, self._left = figure, 1.05 / width_in
        inner_in = height_in - top_in - 0.5
        row_in = (inner_in - between_in * (rows - 1)) / rows
        self.grid = {
            "left": self._left,
            "right": 1 - right_in / width_in,
            "top": 1 - top_in / height_in,
            "bottom": 0.5 / height_in,
            "hspace": between_in / row_in,
        }

    def legend(self, handles: Sequence[Artist]) -> None:
        """One line of keys at the top left."""
        self._figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(self._left, 1.0), ncols=len(handles),
                            borderaxespad=0.2, columnspacing=1.4, handlelength=1.8)  # fmt: skip


def _rows(session: SessionCurves, draw: Callable[[Axes, SessionCurves, int], None], unit: str, row_in: float = _ROW_IN,
          right_in: float = 0.15) -> Figure:  # fmt: skip
    """One row a finger, one time axis, one legend."""
    count = len(session.fingers)
    figure = Figure(figsize=(WIDTH_IN, 1.3 + (row_in + 0.12) * count))
    margins = _Margins(figure, top_in=0.75, right_in=right_in, rows=count)
    panels = figure.subplots(count, 1, sharex=True, sharey=True, squeeze=False, gridspec_kw=margins.grid)[:, 0]
    for axes, finger in zip(panels, session.fingers, strict=True):
        draw(axes, session, finger)
        axes.set_ylabel(f"{FINGERS[finger]}\n({unit})")
    draw_objects(panels[0], session, session.fingers)
    handles, labels = panels[0].get_legend_handles_labels()
    margins.legend(list(dict(zip(labels, handles, strict=True)).values()))
    _end_time_axis(panels[-1], session)
    return figure


def _end_time_axis(axes: Axes, session: SessionCurves) -> None:
    axes.set_xlim(*session.shown_s)
    axes.set_xlabel(_TIME)


def _nothing(session: SessionCurves, *fields: tuple[str, str]) -> bool:
    return all(session.curve(getattr(session.data, series), name, finger) is None
               for series, name in fields for finger in session.fingers)  # fmt: skip
