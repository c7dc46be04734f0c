"""Writes a session's report as one self-contained HTML file."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import htpy as h
import matplotlib as mpl
from htpy import Element, Node
from markupsafe import Markup
from matplotlib.figure import Figure

from common.files.private_file import write_private
from common.fingers import FINGERS, chosen_fingers
from teletaction.plotting.figure_style import STYLE
from teletaction.recordings.machine_verdict import machine_verdict
from teletaction.recordings.session_data import SessionData
from teletaction.recordings.summary import contact_to_motor_s, one_way_s
from teletaction.report.convergence_figure import MOST_TOUCHES, convergence_figure
from teletaction.report.examination import Examination
from teletaction.report.examination_page import finding_blocks, maps, next_page, not_felt, signed_page
from teletaction.report.examination_record import record
from teletaction.report.figures import force_figure, modes_figure, session_figure, temperature_figure, vibration_figure
from teletaction.report.found_lumps import found_lumps
from teletaction.report.report_limits import acted_table, extremes_table
from teletaction.report.report_parts import annex, fact_list, figure, section
from teletaction.report.report_style import CSS
from teletaction.report.report_words import (
    NONE,
    confusion_table,
    contacts_table,
    histogram_table,
    impulses_table,
    latency_table,
    lumps_table,
    packets_table,
    process_table,
    shown,
    tally_table,
    targets_table,
    verdict,
)
from teletaction.report.session_curves import SessionCurves
from teletaction.report.tenderness_part import tenderness_part

_CONTACT_EDGES_MS = (0, 2, 4, 6, 8, 10, 15, 20, 50)
_LINK_EDGES_MS = (0, 0.5, 1, 1.5, 2, 3, 5, 10, 20)

_FIGURES: tuple[tuple[str, Callable[[SessionCurves], Figure | None], str, str], ...] = (
    (
        "Modes over time",
        modes_figure,
        "Lower band: the mode that the remote site identified.",
        "Upper band: the true mode, from the noise-free motion and force of the simulated finger. Names above: the "
        "object touched.",
    ),
    (
        "Vibration",
        vibration_figure,
        "Yellow is the speed that the operator site commanded. Below the dashed line a vibration is not felt.",
        "Blue is true: the speed of the simulated module's motor, which takes time to follow.",
    ),
    (
        "Plate and skin temperature",
        temperature_figure,
        "Dashed orange is the set-point that left the operator site; dotted red is the site's own model of what a "
        "finger on the real object would feel.",
        "Blue and black are true: the simulated plate, and the skin under it.",
    ),
    (
        "Identification converging",
        convergence_figure,
        "Results of the remote site since contact: the probability of its likeliest material, and the object's "
        "temperature with its standard deviation. A dot marks the moment a material was named. Touches shorter than "
        f"1 s are left out; at most {MOST_TOUCHES} are shown.",
        "The thick black line is the true temperature.",
    ),
    (
        "Force",
        force_figure,
        "Yellow is the force that the remote site measured. Right: the largest of each beside its limit.",
        "Black and blue are true, at the simulated devices.",
    ),
)
"""Title, function, caption, and the part of the caption that describes true values of a simulated session."""
_NO_CONSOLE = (
    "No console took part in this recording: it has no study number, no findings, and no audit trail. The map comes "
    "from the touch packets that the operator site received."
)
_OVERVIEW = (
    "One finger over the whole session: what was touched, what the sites identified and displayed, and what was felt."
)
_CONTACTS = (
    "Contacts of at least 1 s. The true material and temperature are those of the simulated object. All other "
    "values are results of the remote site at the end of the contact. The paper's answer comes from its own method "
    "(Kron & Schmidt 2003, Eq. 11) on the same data."
)
_TARGETS = (
    "Targets of the scene, with their places and values on the map. The place is where a quantity stands out most; "
    "the value comes from the nearest touches. True are the middle of the simulated target and its value; a surface "
    "has no true roughness in the sensor’s unit."
)
_LUMPS = (
    "Areas of the map that are a lump with a probability of 0.5 or more, by their stiffness against the ground "
    "around them. Size is that of the area, and not of the nodule below it. True nodules are those of a simulated "
    "scene; one may lie where nothing was pressed."
)
_TRUE = (
    "“True” values come from the simulated world and its devices. A site has measured, estimated or commanded all "
    "other values."
)
_ACTED = "Time for which each limit of a gate acted on a finger since both sites engaged:"
_GROOVES = (
    "Impulses shown to the operator against grooves that the true fingertip crossed. An edge is an impulse at a border "
    "of two objects. One without groove and edge is invented."
)
GENERATOR = '<meta name="generator" content="teletaction">'
"""Mark of each report, by which it is recognised as one."""
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def write_report(
    data: SessionData, summary: Mapping[str, Any], out: Path, examination: Examination | None = None
) -> None:
    """Write the session as one HTML file. It needs no network and no script.

    An examination begins with the page to sign and the page for the next examiner, another session with an overview.
    What is technical stands in an annex, which a screen shows collapsed.

    Args:
        data: the merged recording; streams may be empty.
        summary: content of `summary.json`; the report marks missing parts.
        out: file to write.
        examination: map, findings and audit trail; None: the report covers the signals only.

    Raises:
        OSError: `out` cannot be written.
    """
    count = summary.get("fingers")
    session = SessionCurves.of(data, chosen_fingers(count) if count else _fingers(examination))
    with mpl.rc_context(STYLE):
        write_private(out, str(_page(session, summary, examination)).encode())


def _page(session: SessionCurves, summary: Mapping[str, Any], examination: Examination | None) -> Element:
    title = _title(summary, examination)
    signed = examination is not None and examination.console
    if examination is not None and signed:
        seconds = session.shown_s[1] if len(session.data.rendered) or len(session.data.touch) else None
        front: list[Node] = [
            signed_page(examination, session, seconds),
            next_page(examination),
            finding_blocks(examination, session),
        ]
    else:
        front = [section("Overview", [_header(summary), figure("One session", _one_finger(session), _OVERVIEW)])]
        if examination is not None:
            felt = maps(examination) or h.p["Nothing was felt."]
            front.append(section("Maps", [tenderness_part(examination), felt, not_felt(examination)]))
    lumps = summary.get("lumps") or ([] if examination is None else found_lumps(examination.felt))
    targets = summary.get("targets") or []
    found: list[Node] = [
        section("Targets", [h.p[_TARGETS], targets_table(targets)]) if targets else None,
        section("Lumps", [h.p[_LUMPS], lumps_table(lumps)]) if lumps else None,
        section("Contacts", [h.p[_CONTACTS], tally_table(summary.get("contacts") or [])]) if summary else None,
    ]
    technical: list[Node] = [
        _signals(session),
        _measured(session, summary),
        None if examination is None else record(examination, session.data, summary),
    ]
    return h.html(lang="en")[
        h.head[
            h.meta(charset="utf-8"),
            h.meta(name="viewport", content="width=device-width, initial-scale=1"),
            Markup(GENERATOR),
            h.meta(http_equiv="Content-Security-Policy", content=_POLICY),
            h.title[title],
            h.style[Markup(CSS)],
        ],
        h.body[h.h1[title], front, annex([found, technical]) if signed else [found, annex(technical)]],
    ]


def _one_finger(session: SessionCurves) -> Figure | None:
    """Draw the index finger, or the only one, over the session; None without signals."""
    data = session.data
    known = any(len(series) for series in (data.touch, data.rendered, data.fingertips, data.contact))
    return session_figure(session, session.fingers[len(session.fingers) > 1]) if known else None


def _signals(session: SessionCurves) -> Node:
    """Write the figures of the signals; captions describe true values only where a simulated session has them."""
    simulated = bool(len(session.data.contact) or len(session.data.fingertips))
    return [
        section(title, figure(title, draw(session), f"{true} {caption}" if simulated else caption))
        for title, draw, caption, true in _FIGURES
    ]


def _measured(session: SessionCurves, summary: Mapping[str, Any]) -> Node:
    """Write limits and, where there is a summary, what was measured at the simulated devices."""
    if not summary:
        return section("Limits", [h.p[_ACTED], acted_table(session)])
    modes, taps = summary.get("modes") or {}, summary.get("taps") or {}
    agreement = (
        f"Agreement over the whole time {_percent(modes.get('agreement'))}, "
        f"while in contact {_percent(modes.get('agreement_in_contact'))}."
    )
    delays = [
        histogram_table(times_s, edges, name)
        for times_s, edges, name in (
            (contact_to_motor_s(session.data), _CONTACT_EDGES_MS, "contact to motor command"),
            (one_way_s(session.data), _LINK_EDGES_MS, "touch packet, one way"),
        )
    ]
    tap_counts = f"Taps: {shown(taps.get('made'))} made, {shown(taps.get('played'))} played."
    cores = f"All processes together: {shown(summary.get('cpu_cores'))} cores."
    latency = [latency_table(summary.get("latency_ms") or {}), h.div(".side")[delays]]
    grooves = impulses_table(summary.get("impulses") or {})
    return [
        section("Contacts, one by one", contacts_table(summary.get("contacts") or [])),
        section("Limits", [extremes_table(summary), h.p[_ACTED], acted_table(session)]),
        section("Latency", latency),
        section("Modes identified", [h.p[agreement], confusion_table(modes)]),
        section("Grooves and taps", [h.p[_GROOVES], grooves, h.p[tap_counts]]),
        section("Link", packets_table(summary.get("packets") or {})),
        section("Loops, CPU and memory", [process_table(summary), h.p[cores]]),
    ]


def _fingers(examination: Examination | None) -> Sequence[str]:
    """Return the fingers with a module at the operator site; all fingers if they are not recorded."""
    devices = None if examination is None else examination.figures.get("devices")
    known = devices if isinstance(devices, Mapping) else {}
    return [finger for finger in FINGERS if f"{finger} tacttip" in known] or FINGERS


def _title(summary: Mapping[str, Any], examination: Examination | None) -> str:
    """Return the page's title: the patient's pseudonym, and the scene of a simulated session."""
    pseudonym = None if examination is None else examination.begun.get("pseudonym")
    words = ["Session" if pseudonym is None else f"Examination {shown(pseudonym)}"]
    if summary.get("scene") is not None:
        words.append(f"{shown(summary.get('scene'))}, seed {shown(summary.get('seed'))}")
    return ": ".join(words)


def _header(summary: Mapping[str, Any]) -> Node:
    """Write whether the machine was fast enough, and the main figures."""
    if not summary:
        return h.p[_NO_CONSOLE]
    contacts = summary.get("contacts") or []
    answers = [verdict(contact.get("material"), contact.get("true_material")) for contact in contacts]
    latency = ((summary.get("latency_ms") or {}).get("contact_to_motor") or {}).get("p50")
    words = machine_verdict(summary)
    facts: dict[str, Node] = {
        "duration": f"{shown(summary.get('duration_s'), 1)} s",
        "fingers": shown(summary.get("fingers")),
        "contacts": f"{len(answers)}: " + ", ".join(f"{answers.count(a)} {a}" for a in ("right", "wrong", "no answer")),
        "modes agree": _percent((summary.get("modes") or {}).get("agreement")),
        "contact to motor, median": "–" if latency is None else f"{shown(latency, 1)} ms",
        "faults": _faults(summary.get("faults") or []),
    }
    return [words and h.p[words], fact_list(facts), h.p[_TRUE]]


def _faults(faults: list[Any]) -> Node:
    texts = [f"{f.get('site')}: {f.get('fault')}" if isinstance(f, Mapping) else str(f) for f in faults]
    return h.span(".fault")["; ".join(texts)] if texts else NONE


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.1f} %"
