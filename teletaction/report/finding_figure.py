"""Draws the signals of one finger around the time at which a finding was marked."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from common.fingers import FINGERS
from operator_site.console.texts import named
from teletaction.plotting.figure_style import BLACK, BLUE, GREEN, GREY, ORANGE, RED, absent, label_once, shown_name
from teletaction.report.session_curves import Curve, SessionCurves

BEFORE_S, AFTER_S = 8.0, 2.0
"""Time shown before and after the mark, s."""
NAMED_S = 0.8
"""Shortest time for which a material must be the likeliest to be named in the figure, s."""
_RPM_PER_HZ = 60.0
_LINES = (
    ("force (N)", (("touch", "contact_force_n", "patient", BLACK), ("rendered", "force_n", "operator", BLUE))),
    ("motor (Hz)", (("rendered", "motor_rpm", "motor", BLUE),)),
    (
        "°C",
        (
            ("rendered", "plate_c", "plate", ORANGE),
            ("skin", "felt_c", "skin", RED),
        ),
    ),
)


def signals_figure(session: SessionCurves, finding: Mapping[str, Any]) -> Figure | None:
    """Draw force, vibration, temperatures and identification of the finding's finger; None without recorded data."""
    name, at_s = finding.get("finger"), finding.get("at_s")
    if name not in FINGERS or not isinstance(at_s, int | float):
        return None
    finger, marked_s = FINGERS.index(name), float(at_s) - session.zero_s
    figure = Figure(figsize=(5.6, 4.2), layout="constrained")
    panels = figure.subplots(len(_LINES) + 1, 1, sharex=True)
    drawn = 0
    for axes, (label, lines) in zip(panels[:-1], _LINES, strict=True):
        axes.set_ylabel(label, fontsize=8)
        for series, field, text, colour in lines:
            curve = session.curve(getattr(session.data, series), field, finger)
            share = _RPM_PER_HZ if field == "motor_rpm" else 1.0
            drawn += _draw(axes, curve, marked_s, share, label=text, color=colour)
        label_once(axes, fontsize=7.5, loc="upper left", ncols=3)
    drawn += _draw_identification(panels[-1], session, finger, marked_s)
    for axes in panels:
        axes.axvline(0.0, color=GREY, linewidth=1.0, linestyle="--")
        axes.tick_params(labelsize=8)
    panels[-1].set_xlim(-BEFORE_S, AFTER_S)
    panels[-1].set_xlabel("s from the mark")
    return figure if drawn else None


def _draw(axes: Axes, curve: Curve | None, marked_s: float, share: float, **how: Any) -> int:
    """Draw a line within the shown time; return 1 if there is data, else 0."""
    if curve is None:
        return 0
    since_s = curve.time_s - marked_s
    mine = (since_s >= -BEFORE_S) & (since_s <= AFTER_S)
    if not np.isfinite(curve.value[mine]).any():
        return 0
    thin = Curve(since_s[mine], curve.value[mine] / share).thinned(400)
    axes.plot(thin.time_s, thin.value, linewidth=1.0, **how)
    return 1


def _draw_identification(axes: Axes, session: SessionCurves, finger: int, marked_s: float) -> int:
    """Draw the probability of the likeliest material, named where it stays for NAMED_S.

    Returns 1 if there is data, else 0.
    """
    axes.set_ylabel("likeliest", fontsize=8)
    axes.set_ylim(-0.04, 1.3)
    axes.set_yticks([0.0, 0.5, 1.0])
    rows = [
        row
        for row in session.data.thermal.get(finger, [])
        if row.get("best") and -BEFORE_S <= row["time_s"] - session.zero_s - marked_s <= AFTER_S
    ]
    if not rows:
        absent(axes, "no material identified")
        return 0
    since_s = [row["time_s"] - session.zero_s - marked_s for row in rows]
    axes.plot(since_s, [row["probability"] for row in rows], ".", markersize=3, color=GREEN)
    begun = 0
    for number in range(1, len(rows) + 1):
        if number == len(rows) or rows[number]["best"] != rows[begun]["best"]:
            if since_s[number - 1] - since_s[begun] >= NAMED_S:
                axes.text(since_s[begun], 1.07, shown_name(named(str(rows[begun]["best"])), 16), fontsize=7)
            begun = number
    return 1
