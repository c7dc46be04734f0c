"""Writes the report's pages on the examination: the page to sign, the page for the next examiner, each finding."""

import math
from collections.abc import Mapping
from datetime import datetime
from importlib.util import find_spec
from typing import Any

import htpy as h
from htpy import Element, Node
from markupsafe import Markup

from common.wire.roughness_um import RoughnessUm
from operator_site.console import texts
from operator_site.console.examination.body import body_mark, body_svg
from operator_site.console.examination.contrast import CONFIDENCES, contrast_of
from operator_site.console.examination.findings import QUANTITY, value_text
from operator_site.console.map.map_tiles import picture
from operator_site.console.map.tactile_map import QUANTITIES, ExploredPlace
from teletaction.report.examination import Examination
from teletaction.report.finding_figure import AFTER_S, BEFORE_S, signals_figure
from teletaction.report.found_lumps import suggested_lumps
from teletaction.report.map_coverage import Coverage, coverage
from teletaction.report.map_figure import UNITS, cutout_figure, map_figure
from teletaction.report.report_limits import reached
from teletaction.report.report_parts import embedded, fact_list, figure, section
from teletaction.report.report_words import shown, table
from teletaction.report.session_curves import SessionCurves
from teletaction.report.tenderness_part import tenderness_part

CUTOUT_M = 0.040
"""Width of the map around a finding, m."""
LONGEST_IN_TABLE = 160
"""Largest number of letters of a note on the opening page."""
OPENING_IN = (7.0, 3.6)
"""Width and largest height of the map on the first page, inches."""
_TO_FILL_IN = [
    h.h3["Conclusion"],
    h.div(".line"),
    h.div(".line"),
    h.div(".signatures")[[h.div(".line")[name] for name in ("Examiner", "Date", "Signature")]],
]
_LATE_S = 2.0
"""Largest delay of the operator site's first message after the begin that is not mentioned, s."""
_BEFORE = "What was felt before is not in this report."
_OUTLINES = "Dashed outlines: lumps that the stiffness of the surface suggests, with their probability."
_READING = (
    "Opacity shows confidence: full colour for high confidence, stippled for low confidence, a single dot for none. "
    "Areas that were not felt are hatched. In the map of temperature, + and − mark places at least 1 K above and "
    "below the middle of its scale. The value of a finding comes from the touches within 3 mm of it. "
    "Its confidence says how surely it differs from its surroundings."
)


def signed_page(examination: Examination, session: SessionCurves, seconds: float | None) -> Element:
    """Write the page that a clinician signs: patient, map, findings, completeness, limits, conclusion, signature.

    Args:
        examination: its content.
        session: the signals, for the limits that acted.
        seconds: duration to show if no start and end are recorded, s.
    """
    begun, findings = examination.begun, examination.valid_findings()
    withdrawn = len(examination.findings) - len(findings)
    facts = {
        "study number": shown(begun.get("pseudonym")),
        "begun": shown(_wall_clock(begun.get("wall_clock"))),
        "duration": _duration(examination, seconds),
        "at the console": shown(begun.get("who")),
        "findings": f"{len(findings)}, and {withdrawn} withdrawn" if withdrawn else str(len(findings)),
    }
    if consent := examination.consent():
        confirmed = ", confirmed by the patient at the begin" if begun.get("consented") else ""
        facts["consent to record"] = f"{consent}{confirmed}"
    if body := body_mark(begun):
        facts["place on the body"] = body.text()
    quantity = _first_quantity(examination)
    lumps = suggested_lumps(examination.felt)
    drawn = None if quantity is None else map_figure(examination.felt, quantity, findings, *OPENING_IN, lumps)
    caption = "" if quantity is None else f"{quantity.capitalize()} over the explored surface. {_sides(begun)}"
    caption += _OUTLINES if lumps else ""
    return h.section(".signed")[
        None if body is None else h.div(".body-mark")[Markup(body_svg(body))],
        fact_list(facts),
        figure("Map with findings", drawn, caption) if drawn else h.p["Nothing was felt."],
        h.h3["Findings"],
        findings_table(examination),
        h.h3["Completeness"],
        h.p[f"{_completeness(examination)} {_moved(examination)}{_limits(examination, session)}"],
        _TO_FILL_IN,
    ]


def next_page(examination: Examination) -> Element:
    """Write the page for the next examiner: what was not felt, and the maps of all quantities."""
    return section(
        "For the next examiner",
        [h.h3["Not felt"], not_felt(examination), tenderness_part(examination), maps(examination)],
        "next",
    )


def findings_table(examination: Examination) -> Element:
    """Write the table of findings, one row each, with or without a place."""
    rows = []
    for finding in examination.findings.values():
        place = [_mm(finding.get(name)) for name in ("x_m", "y_m")]
        where = ", ".join(place) if "–" not in place else "a moment, no place"
        row: list[Node] = [
            h.b[shown(finding.get("id"))],
            shown(finding.get("kind")),
            [where, None if (body := body_mark(finding)) is None else [h.br, body.text()]],
            [h.span(".value")[shown(finding.get("text"))], (compare := finding.get("compare")) and [h.br, compare]],
            shown(confidence(examination, finding)),
            h.span(".note")[_beginning(str(finding.get("note") or "–"))],
        ]
        if reason := finding.get("withdrawn"):
            *struck, last = (h.del_(".withdrawn")[cell] for cell in row)
            row = [*struck, [last, h.br, f"Withdrawn: {reason}"]]
        rows.append(row)
    return table(("", "kind", "x, y (mm)", "felt", "confidence", "note"), rows)


def confidence(examination: Examination, finding: Mapping[str, Any]) -> str | None:
    """Return the confidence that a finding differs from its surroundings, one of CONFIDENCES.

    Recordings without it get it from the map at the end; None for a finding without a quantity or a place.
    """
    here, kind = place_of(examination, finding), finding.get("kind")
    if here is None or kind not in QUANTITY:
        return None
    if finding.get("confidence"):
        return str(finding["confidence"])
    differs = contrast_of(kind, here, examination.felt.around(here.x_m, here.y_m))
    return CONFIDENCES[0] if differs is None else differs.confidence


def place_of(examination: Examination, finding: Mapping[str, Any]) -> ExploredPlace | None:
    """Return the final values of the maps at the place of a finding; None without a place."""
    x_m, y_m = finding.get("x_m"), finding.get("y_m")
    return None if x_m is None or y_m is None else examination.felt.at(float(x_m), float(y_m))


def not_felt(examination: Examination) -> Element:
    """Write the table of what the maps lack: quantities never felt and gaps between lines."""
    rows: list[list[Node]] = []
    for quantity in QUANTITIES:
        covered = covered_by(examination, quantity)
        if covered is None:
            rows.append([quantity, "not felt anywhere", "", ""])
            continue
        lines = f"up to {1e3 * covered.lines_m:.0f} mm apart"
        rows.append(
            [
                quantity,
                f"{1e4 * (covered.explored_m2 - covered.felt_m2):.1f} of {1e4 * covered.explored_m2:.1f} cm²",
                f"{100.0 * covered.share:.0f} %",
                h.b[f"{lines}: lines more than 6 mm apart"] if covered.gaps else lines.replace("up to", "at most"),
            ]
        )
    return table(("", "not felt within the explored outline", "felt", "lines or presses"), rows)


def covered_by(examination: Examination, quantity: str) -> Coverage | None:
    """Return the coverage of the surface for a quantity; None if it was never felt."""
    drawn = picture(examination.felt, quantity)
    return None if drawn is None else coverage(drawn)


def maps(examination: Examination) -> Node:
    """Write the maps of all quantities that were felt; None if none was."""
    findings = examination.valid_findings()
    drawn = [
        h.div[
            h.h3[quantity.capitalize()],
            figure(f"Map of {quantity}", map_figure(examination.felt, quantity, findings), _words(covered)),
        ]
        for quantity in QUANTITIES
        if (covered := covered_by(examination, quantity)) is not None
    ]
    return [h.div(".maps")[drawn], h.p[_READING]] if drawn else None


def finding_blocks(examination: Examination, session: SessionCurves) -> Element | None:
    """Write half a page for each finding: its surroundings on the map, and the signals around its time."""
    blocks = []
    for finding in examination.valid_findings():
        number = shown(finding.get("id"))
        here = place_of(examination, finding)
        quantity = QUANTITY.get(str(finding.get("kind"))) or _known_here(here) or "temperature"
        cut = cutout_figure(examination.felt, quantity, finding, CUTOUT_M)
        if cut is None:
            surroundings = h.p["No place." if here is None else f"No {quantity} was felt here."]
        else:
            surroundings = figure(f"Surroundings of finding {number}", cut, f"{quantity}, {1e3 * CUTOUT_M:.0f} mm wide")
        signals = signals_figure(session, finding)
        caption = (
            f"{BEFORE_S:g} s before to {AFTER_S:g} s after the finding was marked; finger: {finding.get('finger')}"
        )
        curves = figure(f"Signals at finding {number}", signals, caption) if signals else h.p["No signals recorded."]
        blocks.append(
            h.div(".finding")[
                h.h3[f"Finding {number}: {shown(finding.get('text'))}"],
                h.p[_in_words(finding, here, examination.felt.roughness_um)],
                h.div(".pair")[h.div[surroundings, _seen(examination, finding)], h.div[curves]],
            ]
        )
    return section("Findings, one by one", blocks) if blocks else None


def _seen(examination: Examination, finding: Mapping[str, Any]) -> Element | None:
    """Write what the camera showed when a finding was marked; None without a recorded picture."""
    number = shown(finding.get("id"))
    still = examination.stills.get(finding["id"])
    if still is None:
        missing = examination.pictures and find_spec("av") is None
        return h.p["The recording has pictures: install the extra `camera` to see them here."] if missing else None
    caption = f"Camera {still.before_s:.2f} s before the mark, ± {1e3 * still.uncertainty_s:.0f} ms"
    if still.is_covered:
        caption += "; covered outside the surroundings of the marks, or everywhere without marks"
    return embedded(f"Camera at finding {number}", "jpeg", still.jpeg, caption)


def _in_words(finding: Mapping[str, Any], here: ExploredPlace | None, scale: RoughnessUm | None) -> Node:
    """Describe a finding: its difference from the surroundings, the values felt there by the end, and the note."""
    lines: list[Node] = [finding["compare"]] if finding.get("compare") else []
    if here is not None:
        known = [
            f"{quantity} {value_text(quantity, value, scale)} ({texts.count(value.touches, 'touch')})"
            for quantity in UNITS
            if (value := getattr(here, quantity)) is not None
        ]
        if here.material is not None:
            known.append(f"material {texts.named(here.material[0])} ({100.0 * here.material[1]:.0f} % of the touches)")
        lines.append("Within 3 mm by the end: " + ("; ".join(known) or "nothing felt") + ".")
    if finding.get("note"):
        lines.append(["Note: ", h.span(".note")[finding["note"]]])
    return [[bool(number) and h.br, line] for number, line in enumerate(lines)]


def _words(covered: Coverage) -> str:
    said = f"{1e4 * covered.felt_m2:.1f} cm² felt, {100.0 * covered.share:.0f} % of what was explored. "
    return said + (f"Lines more than 6 mm apart: up to {1e3 * covered.lines_m:.0f} mm." if covered.gaps else "")


def _completeness(examination: Examination) -> str:
    """Return how much of the explored area each quantity covers, and how much later its recording begins."""
    shares = []
    for quantity in QUANTITIES:
        covered = covered_by(examination, quantity)
        shares.append(f"{quantity} " + ("nowhere" if covered is None else f"on {100.0 * covered.share:.0f}\u00a0%"))
    began_s, from_s = examination.begun.get("at_s"), examination.operator_s
    late_s = 0.0 if began_s is None or from_s is None else from_s - float(began_s)
    late = ""
    if late_s > _LATE_S:  # a site that was restarted has set its earlier recording aside
        late = f" The operator site's recording begins {texts.duration(late_s)} after the examination. {_BEFORE}"
    return f"Felt within the explored outline: {', '.join(shares)}.{late}"


def _moved(examination: Examination) -> str:
    """Return the movements of the patient, each with the time since the examination's begin, in sentences."""
    began_s = examination.begun.get("at_s")
    said = ""
    for movement in examination.movements:
        since_s = None if began_s is None else movement.since_s - float(began_s)
        after = "" if since_s is None else f"After {texts.duration(since_s)}: "
        said += f"{after}{texts.moved(movement.by_m)} "
    return said


def _limits(examination: Examination, session: SessionCurves) -> str:
    """Return the limits that acted between begin and end of the examination, in sentences."""
    began_s = examination.begun.get("at_s")
    return reached(session, None if began_s is None else float(began_s), examination.ended_s)


def _first_quantity(examination: Examination) -> str | None:
    """Return the quantity of most findings; without findings, the quantity felt on the largest area."""
    about = [QUANTITY[kind] for f in examination.valid_findings() if (kind := str(f.get("kind"))) in QUANTITY]
    covered_by_quantity = {quantity: covered_by(examination, quantity) for quantity in QUANTITIES[:3]}
    known = {quantity: covered.felt_m2 for quantity, covered in covered_by_quantity.items() if covered is not None}
    if not known:
        return None
    return max(known, key=lambda quantity: (about.count(quantity), known[quantity]))


def _known_here(here: ExploredPlace | None) -> str | None:
    return next((quantity for quantity in UNITS if getattr(here, quantity, None) is not None), None)


def _duration(examination: Examination, seconds: float | None) -> str:
    began_s = examination.begun.get("at_s")
    if examination.ended_s is not None and began_s is not None:
        seconds = examination.ended_s - float(began_s)
    if seconds is None or not math.isfinite(seconds):
        return "–"
    return texts.duration(seconds)


def _wall_clock(text: Any) -> str | None:
    """Format a date and time for reading, with its zone as far as known; return other text unchanged."""
    try:
        begun = datetime.fromisoformat(str(text))
    except ValueError:
        return None if text is None else str(text)
    return f"{begun.day} {begun:%B %Y, %H:%M %Z}".strip()


def _beginning(note: str) -> str:
    """Shorten a note for the table. The full note is printed with its finding."""
    return note if len(note) <= LONGEST_IN_TABLE else f"{note[:LONGEST_IN_TABLE]}… (all of it below)"


def _sides(begun: Mapping[str, Any]) -> str:
    sides = begun.get("sides")
    if not isinstance(sides, Mapping):
        return ""
    return "".join(f"{side.capitalize()} edge: {name}. " for side, name in sides.items() if isinstance(name, str))


def _mm(value: Any) -> str:
    return "–" if value is None else texts.whole(1e3 * float(value))
