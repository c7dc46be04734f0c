"""Draws how the identification of each touch converged: probability and object temperature since contact."""

import math
from collections import Counter
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from common.wire.messages import ThermalStatus
from teletaction.plotting.figure_layout import WIDTH_IN, Margins
from teletaction.plotting.figure_style import BLACK, FINGER_COLOURS, FINGER_DASHES, finger_keys, shown_name
from teletaction.recordings.columns import Floats
from teletaction.recordings.true_touches import SHORTEST_TOUCH_S
from teletaction.report.finger_panels import ANSWERING
from teletaction.report.session_curves import SessionCurves, SharedTouch

MOST_TOUCHES = 12
"""Largest number of touches in the figure. The table of contacts lists all touches."""


def convergence_figure(session: SessionCurves) -> Figure | None:
    """Draw probability and object temperature since contact, two panels for each touched object; None without data."""
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
    margins = Margins(figure, top_in=0.95, between_in=1.1, rows=rows)
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
    keys = [
        *finger_keys(session.fingers),
        Line2D([], [], color=BLACK, linewidth=2.4, label="true temperature"),
        Line2D([], [], color=BLACK, marker="o", linestyle="none", label="named here"),
    ]
    margins.legend(keys)
    return figure


def _draw_converging(session: SessionCurves, shared: SharedTouch, upper: Axes, lower: Axes) -> None:
    said: Counter[str] = Counter()
    estimated = False
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
        known_c = mean[np.isfinite(mean)]
        if len(known_c) > 2:
            estimated = True
            seen += np.percentile(known_c, (10, 90)).tolist()
        lower.plot([0, longest_s], [touch.object_c] * 2, color=BLACK, linewidth=2.4, zorder=1.5)
    true = ", ".join(dict.fromkeys(t.material for t in shared.touches))
    answered = ", ".join(f"{count} × {what}" for what, count in said.most_common())
    title: dict[str, Any] = {"loc": "left", "fontsize": 9.0, "fontweight": "bold", "pad": 30}
    upper.set_title(_fitted(f"{shared.thing}, at {shared.start_s:.0f} s"), **title)
    upper.annotate(
        f"{_fitted('true: ' + true)}\n{_fitted('identified: ' + answered)}",
        (0, 1),
        xytext=(0, 4),
        fontsize=8.5,
        xycoords="axes fraction",
        textcoords="offset points",
    )
    upper.set_ylim(-0.04, 1.08)
    upper.set_yticks([0, 0.5, 1])
    upper.tick_params(labelbottom=False)
    upper.set_xlim(0, max(longest_s, 1.0))
    if not estimated:
        lower.text(0.5, 0.75, "no temperature known", transform=lower.transAxes, ha="center", color="#5A5A5A")
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
    """Shorten a line to the width of a narrow panel."""
    return shown_name(text, 34)


def _known(session: SessionCurves, shared: SharedTouch, name: str) -> list[bool]:
    return [a.get(name) is not None and a.get("best") is not None for t in shared.touches for a in session.answers(t)]
