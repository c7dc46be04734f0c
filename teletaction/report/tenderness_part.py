"""Writes the report's part on tenderness: a map of all presses with their answers, and what they say."""

import htpy as h
from htpy import Element
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from operator_site.console.tenderness.pain_presses import quiet_places
from operator_site.console.tenderness.tender_search import CIRCLE_SD, Tenderness
from operator_site.console.texts import ALIKE, NOT_KNOWN_YET, whole
from teletaction.plotting.figure_style import BLACK, BLUE, RED
from teletaction.report.examination import Examination
from teletaction.report.map_figure import HALO
from teletaction.report.report_parts import fact_list, figure
from teletaction.report.report_words import shown

_SIZE_IN = (5.2, 3.9)
_POINTS_N = 5.0
"""Size of a marker for each newton, points, beside its least size of 3 points."""
_CAPTION = (
    "Rings: presses without pain, the larger the harder. Filled: reports of pain, with the force at which the pain "
    "began. The cross is the most tender place, the dashed circle holds it with a probability of 95 %."
)


def tenderness_part(examination: Examination) -> Element | None:
    """Write map and figures of tenderness; None where no pain was recorded, which needs the patient's consent."""
    found = examination.tenderness()
    if not found.reports:
        return None
    place, reaction_s, threshold_n = found.place_mm, found.known_reaction_s, found.known_threshold_n
    where = NOT_KNOWN_YET
    if place is not None:
        x, y, sd = place
        where = f"x {whole(x)}, y {whole(y)} mm, ± {max(1.0, sd):.0f} mm{ALIKE if found.alike else ''}"
    interval = "" if found.place is None else f" (90 %: {found.place.low_n:.1f} to {found.place.high_n:.1f} N)"
    return h.div[
        h.h3["Tenderness"],
        figure("Map of tenderness", tenderness_figure(examination, found), _CAPTION),
        fact_list(
            {
                "most tender place, ± sd": where,
                "pain from": NOT_KNOWN_YET if threshold_n is None else f"{threshold_n:.1f} N{interval}",
                "reaction time": NOT_KNOWN_YET
                if reaction_s is None
                else f"{reaction_s:.2f} ± {found.reaction_sd_s:.2f} s",
                "presses with pain": f"{shown(found.reports)} of {shown(len(found.presses))}",
            }
        ),
    ]


def tenderness_figure(examination: Examination, found: Tenderness) -> Figure:
    """Draw all presses with a known answer, the reports of pain, and the most tender place."""
    drawn = Figure(figsize=_SIZE_IN, layout="constrained")
    axes = drawn.subplots()
    for x_m, y_m, peak_n in quiet_places(found.presses):
        _mark(axes, x_m, y_m, peak_n, BLUE, "none")
    for report in examination.pain.reports:
        _mark(axes, report.x_m, report.y_m, report.threshold_n, RED, RED)
        axes.annotate(
            f"{report.threshold_n:.1f} N",
            (1e3 * report.x_m, 1e3 * report.y_m),
            (7, 5),
            textcoords="offset points",
            fontsize=8.5,
            path_effects=[HALO],
            zorder=4,
        )
    if found.place_mm is not None:
        x, y, sd = found.place_mm
        axes.plot(x, y, "+", color=BLACK, markersize=14, markeredgewidth=1.6)
        axes.add_patch(Circle((x, y), CIRCLE_SD * sd, fill=False, linestyle="--", linewidth=1.2))
        axes.plot([x - CIRCLE_SD * sd, x + CIRCLE_SD * sd], [y - CIRCLE_SD * sd, y + CIRCLE_SD * sd], alpha=0.0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x, mm")
    axes.set_ylabel("y, mm")
    return drawn


def _mark(axes: Axes, x_m: float, y_m: float, force_n: float, edge: str, face: str) -> None:
    axes.plot(
        1e3 * x_m,
        1e3 * y_m,
        "o",
        markersize=3.0 + _POINTS_N * force_n**0.5,
        markeredgecolor=edge,
        markerfacecolor=face,
        alpha=0.8,
    )
