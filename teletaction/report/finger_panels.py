"""Draws the signals of one finger, one quantity in each panel, for the report and the one-finger figure.

True values of the simulated world are black or filled; estimates and commands of a site are coloured.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from common.limits import COMFORT, MOTOR_FLOOR_RPM
from common.wire.messages import ThermalStatus
from teletaction.plotting.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MODE_COLOURS,
    ORANGE,
    PLUM,
    RED,
    STATUS_COLOURS,
    absent,
    shown_name,
)
from teletaction.recordings.session_data import Series
from teletaction.recordings.true_touches import SHORTEST_TOUCH_S
from teletaction.report.session_curves import Curve, SessionCurves, spans

_MOST_MATERIALS = 9
"""Largest number of materials in the panel of materials."""
_LINE_BINS = 1000
"""Number of bins of a curve. Each bin is about a pixel wide and is drawn by two points."""
ANSWERING = (ThermalStatus.DECIDING, ThermalStatus.IDENTIFIED, ThermalStatus.AMBIGUOUS)
"""Statuses in which an estimated object temperature is valid."""


def draw_modes(axes: Axes, session: SessionCurves, fingers: tuple[int, ...], names: tuple[str, ...]) -> None:
    """Draw two bands for each finger: the true mode above the identified one."""
    ticks: list[tuple[float, str]] = []
    drawn = False
    for row, finger in enumerate(fingers):
        bands = (
            (f"{names[finger]}  true", session.curve(session.data.contact, "mode", finger), -row + 0.02),
            ("identified", session.curve(session.data.touch, "mode", finger), -row - 0.40),
        )
        for label, curve, bottom in bands:
            ticks.append((bottom + 0.19, label))
            for mode, colour in MODE_COLOURS.items():
                found = [(start, end - start) for start, end, number in spans(curve) if number == mode] if curve else []
                axes.broken_barh(found, (bottom, 0.38), facecolors=colour, edgecolor=colour, linewidth=0.5)
                drawn = drawn or bool(found)
    axes.set_yticks([at for at, _ in ticks], [label for _, label in ticks])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(-len(fingers) + 0.5, 0.5)
    axes.grid(visible=False, axis="y")
    if not drawn:
        absent(axes, "no modes recorded")


def draw_objects(axes: Axes, session: SessionCurves, fingers: tuple[int, ...]) -> None:
    """Write the names of the touched objects above a panel, on up to three lines. Names without room are left out."""
    width_s = session.shown_s[1] - session.shown_s[0]
    inches = axes.get_position().width * axes.figure.get_figure(root=True).get_figwidth()
    letter_s = 0.078 * width_s / inches
    taken = [-np.inf] * 3
    for shared in session.shared_touches(fingers, SHORTEST_TOUCH_S / 2):
        name = shown_name(shared.thing)
        middle_s = (shared.start_s + shared.end_s) / 2
        half_s = letter_s * len(name) / 2
        level = next((n for n, end_s in enumerate(taken) if middle_s - half_s > end_s), None)
        if level is None:
            continue
        taken[level] = middle_s + half_s + letter_s
        axes.annotate(
            name,
            (middle_s, 1.0),
            xytext=(0, 3 + 11 * level),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=8.5,
            annotation_clip=False,
        )


def draw_vibration(axes: Axes, session: SessionCurves, finger: int) -> None:
    """Draw the motor speed, true and commanded, with the perception threshold."""
    data = session.data
    bands: tuple[tuple[Series, str, dict[str, Any]], ...] = (
        (data.rendered, "commanded by the operator site", {"color": "#F3C96B", "linewidth": 0.6}),
        (data.fingertips, "true, at the module", {"color": BLUE, "linewidth": 0.6}),
    )
    curves = [session.curve(series, "motor_rpm", finger) for series, _, _ in bands]
    for curve, (_, label, how) in zip(curves, bands, strict=True):
        if curve is not None:
            thin = curve.thinned(_LINE_BINS)
            axes.fill_between(thin.time_s, thin.value, label=label, **how)
    axes.axhline(
        MOTOR_FLOOR_RPM, color=GREY, linestyle="--", linewidth=0.9, label=f"felt above {MOTOR_FLOOR_RPM:g} rpm"
    )
    axes.set_ylim(bottom=0.0)
    if not any(curves):
        absent(axes, "no vibration recorded")


def draw_temperature(axes: Axes, session: SessionCurves, finger: int) -> None:
    """Draw plate temperature (set-point and true) and skin temperature (modelled and true)."""
    data = session.data
    lines = (
        (data.rendered, "plate_set_c", "plate set by the operator site", {"color": ORANGE, "linestyle": "--"}),
        (data.fingertips, "plate_c", "plate, true", {"color": BLUE}),
        (data.skin, "felt_c", "skin wanted by the site's model", {"color": RED, "linestyle": ":", "linewidth": 1.6}),
        (data.fingertips, "felt_c", "skin, true", {"color": BLACK, "linewidth": 1.6}),
    )
    drawn = [_line(axes, session.curve(series, name, finger), label=label, **how) for series, name, label, how in lines]
    if not any(drawn):
        absent(axes, "no temperatures recorded")


def draw_comfort(axes: Axes) -> None:
    """Draw the limits of the comfort profile and extend the axis to show them."""
    for edge_c in (COMFORT.low_c, COMFORT.high_c):
        axes.axhline(edge_c, color=GREY, linestyle="--", linewidth=0.9, label="comfort range of the plate")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, COMFORT.low_c - 1.5), max(high, COMFORT.high_c + 1.5))


def draw_probability(axes: Axes, session: SessionCurves, finger: int) -> None:
    """Draw the probability of the likeliest material as dots in the colour of the status."""
    probability, status = session.thermal(finger, "probability"), session.thermal(finger, "status")
    axes.set_ylim(-0.04, 1.06)
    axes.set_yticks([0.0, 0.5, 1.0])
    if probability is None or status is None:
        absent(axes, "no thermal answers recorded")
        return
    for number, colour in STATUS_COLOURS.items():
        mine = status.value == number
        axes.plot(probability.time_s[mine], probability.value[mine], ".", color=colour, markersize=4)


def draw_materials(axes: Axes, session: SessionCurves, finger: int) -> None:
    """Draw the likeliest material over time in the colour of the status, and the true one as a black frame."""
    rows = [row for row in session.data.thermal.get(finger, []) if row.get("best") and row["status"] in STATUS_COLOURS]
    touches = [t for t in session.touches if t.finger == finger and t.end_s - t.start_s >= SHORTEST_TOUCH_S / 2]
    counted: dict[str, int] = {}
    for touch in touches:
        counted[touch.material] = counted.get(touch.material, 0) + 1000
    for row in rows:
        counted[row["best"]] = counted.get(row["best"], 0) + 1
    materials = sorted(counted, key=lambda name: -counted[name])[:_MOST_MATERIALS]
    place = {name: number for number, name in enumerate(materials)}
    axes.set_yticks(range(len(materials)), [shown_name(name) for name in materials])
    axes.set_ylim(max(len(materials), 1) - 0.4, -0.6)
    if not materials:
        absent(axes, "no object touched long enough to name it")
        return
    for touch in touches:
        if touch.material in place:
            frame = ((touch.start_s, touch.end_s - touch.start_s), (place[touch.material] - 0.42, 0.84))
            axes.broken_barh([frame[0]], frame[1], facecolors="none", edgecolor=BLACK, linewidth=1.2)
    for number, colour in STATUS_COLOURS.items():
        mine = [row for row in rows if row["status"] == number and row["best"] in place]
        axes.plot(
            [row["time_s"] - session.zero_s for row in mine],
            [place[row["best"]] for row in mine],
            "|",
            color=colour,
            markersize=6.5,
            markeredgewidth=2.2,
        )


def draw_object_c(axes: Axes, session: SessionCurves, finger: int) -> None:
    """Draw the estimated object temperature with its standard deviation, and the true one."""
    curves = [session.thermal(finger, name) for name in ("object_c", "object_c_sd", "exponential_object_c", "status")]
    estimate, deviation, paper, status = curves
    touches = [t for t in session.touches if t.finger == finger]
    seen: list[float] = [t.object_c for t in touches if np.isfinite(t.object_c)]
    for number, touch in enumerate(touches):
        axes.plot(
            [touch.start_s, touch.end_s],
            [touch.object_c] * 2,
            color=BLACK,
            linewidth=2.4,
            solid_capstyle="butt",
            label="true" if number == 0 else None,
        )
    if status is not None and estimate is not None and deviation is not None:
        answered = np.isin(status.value, ANSWERING)
        value = np.where(answered, estimate.value, np.nan)
        axes.fill_between(
            estimate.time_s,
            value - deviation.value,
            value + deviation.value,
            color=GREEN,
            alpha=0.25,
            linewidth=0,
            label="± standard deviation",
        )
        axes.plot(estimate.time_s, value, color=GREEN, linewidth=1.6, label="estimated by the remote site")
        seen += np.percentile(value[np.isfinite(value)], (5, 95)).tolist() if np.isfinite(value).any() else []
        if paper is not None:
            paper_c = np.where(answered, paper.value, np.nan)
            axes.plot(paper.time_s, paper_c, ".", color=PLUM, markersize=2.5, label="by the paper's Eq. 11")
            seen += np.percentile(paper_c[np.isfinite(paper_c)], (5, 95)).tolist() if np.isfinite(paper_c).any() else []
    if seen:
        axes.set_ylim(min(seen) - 1.5, max(seen) + 1.5)
    else:
        absent(axes, "no object temperature known")


def draw_force(axes: Axes, session: SessionCurves, finger: int) -> None:
    """Draw the force at the operator's finger and the force on the patient."""
    data = session.data
    lines = (
        (data.touch, "contact_force_n", "on the patient, measured", {"color": "#F3C96B", "linewidth": 3.0}),
        (data.contact, "force_n", "on the patient, true", {"color": BLACK}),
        (data.fingertips, "force_n", "at the operator's finger, true", {"color": BLUE}),
    )
    drawn = [_line(axes, session.curve(series, name, finger), label=label, **how) for series, name, label, how in lines]
    axes.set_ylim(bottom=0.0)
    if not any(drawn):
        absent(axes, "no forces recorded")


def _line(axes: Axes, curve: Curve | None, **how: Any) -> bool:
    """Draw a curve, thinned; return False if there is none."""
    if curve is None:
        return False
    thin = curve.thinned(_LINE_BINS)
    axes.plot(thin.time_s, thin.value, **how)
    return True
