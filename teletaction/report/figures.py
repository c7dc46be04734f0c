"""Draws the figures of a session. A function returns None if the recording has no data for its figure.

The code uses matplotlib's objects without pyplot, so that no figure stays in memory.
"""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from common.fingers import FINGERS
from common.limits import CONTACT_FORCE_N, FINGER_FORCE_N
from teletaction.plotting.figure_layout import WIDTH_IN, Margins
from teletaction.plotting.figure_style import BLACK, BLUE, label_once, mode_keys, status_keys
from teletaction.report.finger_panels import (
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
from teletaction.report.session_curves import SessionCurves

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
    """Draw one finger over the whole session in seven panels, 16 x 10 inches."""
    figure = Figure(figsize=(16, 10))
    grid = {"left": 0.1, "right": 0.795, "top": 0.925, "bottom": 0.055, "hspace": 0.16}
    heights = (0.62, 1.0, 1.25, 1.25, 0.75, 1.05, 0.9)
    panels = figure.subplots(7, 1, sharex=True, height_ratios=heights, gridspec_kw=grid)
    figure.suptitle(
        f"One session, {FINGERS[finger]} finger: what was touched, identified, shown and felt",
        x=0.1,
        y=0.985,
        ha="left",
        fontsize=13,
        fontweight="bold",
    )
    modes, vibration, temperature, materials, probability, object_c, force = panels
    draw_modes(modes, session, (finger,), ("",) * len(FINGERS))
    draw_objects(modes, session, (finger,))
    draw_vibration(vibration, session, finger)
    draw_temperature(temperature, session, finger)
    draw_materials(materials, session, finger)
    draw_probability(probability, session, finger)
    draw_object_c(object_c, session, finger)
    draw_force(force, session, finger)
    for axes, label in zip(panels, _LABELS, strict=True):
        axes.set_ylabel(label)
    figure.align_ylabels(list(panels))
    aside = {"loc": "center left", "bbox_to_anchor": (1.005, 0.5), "borderaxespad": 0.0, "handlelength": 1.6}
    modes.legend(handles=mode_keys(), **aside, ncols=2, columnspacing=1.0)
    materials.legend(
        handles=[
            Line2D([], [], color=BLACK, marker="s", markerfacecolor="none", linestyle="none", label="true material"),
            *status_keys(),
        ],
        **aside,
    )
    for axes in (vibration, temperature, object_c, force):
        label_once(axes, **aside, markerscale=2.5)
    _end_time_axis(panels[-1], session)
    return figure


def modes_figure(session: SessionCurves) -> Figure | None:
    """Draw the true mode above the identified mode of every finger."""
    if _nothing_recorded(session, ("contact", "mode"), ("touch", "mode")):
        return None
    figure = Figure(figsize=(WIDTH_IN, 1.5 + 0.62 * len(session.fingers)))
    margins = Margins(figure, top_in=0.85)
    axes = figure.subplots(gridspec_kw=margins.grid)
    draw_modes(axes, session, session.fingers, FINGERS)
    draw_objects(axes, session, session.fingers)
    margins.legend(mode_keys())
    _end_time_axis(axes, session)
    return figure


def vibration_figure(session: SessionCurves) -> Figure | None:
    """Draw the motor speed at each module, one row for each finger."""
    if _nothing_recorded(session, ("rendered", "motor_rpm"), ("fingertips", "motor_rpm")):
        return None
    return _rows(session, draw_vibration, "rpm")


def temperature_figure(session: SessionCurves) -> Figure | None:
    """Draw plate and skin temperatures, one row for each finger."""
    if _nothing_recorded(session, ("rendered", "plate_set_c"), ("fingertips", "plate_c"), ("skin", "felt_c")):
        return None

    def draw(axes: Axes, session: SessionCurves, finger: int) -> None:
        draw_temperature(axes, session, finger)
        draw_comfort(axes)

    return _rows(session, draw, "°C", row_in=1.35)


def force_figure(session: SessionCurves) -> Figure | None:
    """Draw the forces, one row for each finger, and beside them each maximum against its limit."""
    if _nothing_recorded(session, ("fingertips", "force_n"), ("contact", "force_n"), ("touch", "contact_force_n")):
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


def _rows(
    session: SessionCurves,
    draw: Callable[[Axes, SessionCurves, int], None],
    unit: str,
    row_in: float = _ROW_IN,
    right_in: float = 0.15,
) -> Figure:
    """Draw one row for each finger, with one time axis and one legend."""
    count = len(session.fingers)
    figure = Figure(figsize=(WIDTH_IN, 1.3 + (row_in + 0.12) * count))
    margins = Margins(figure, top_in=0.75, right_in=right_in, rows=count)
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
    """Label the session's time below the lowest panel."""
    axes.set_xlim(*session.shown_s)
    axes.set_xlabel("time since both sites engaged (s)")


def _nothing_recorded(session: SessionCurves, *fields: tuple[str, str]) -> bool:
    """Return True if none of these fields (series, name) has a value for a finger in use."""
    return all(
        session.curve(getattr(session.data, series), name, finger) is None
        for series, name in fields
        for finger in session.fingers
    )
