"""The session as one HTML file that needs nothing else, and the picture of one finger."""

import base64
from collections.abc import Callable, Mapping
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from common.fingers import FINGERS
from teletaction.convergence_figure import MOST_TOUCHES, convergence_figure
from teletaction.figure_style import STYLE
from teletaction.figures import (
    force_figure,
    modes_figure,
    session_figure,
    temperature_figure,
    vibration_figure,
)
from teletaction.report_limits import acted_table, extremes_table
from teletaction.report_style import CSS
from teletaction.report_words import (
    NONE,
    confusion_table,
    contacts_table,
    histogram_table,
    impulses_table,
    latency_table,
    packets_table,
    process_table,
    shown,
    tally_table,
    verdict,
)
from teletaction.session_curves import SessionCurves
from teletaction.session_data import SessionData
from teletaction.summary import contact_to_motor_s, one_way_s

_DPI = 140
_CONTACT_EDGES_MS = (0, 2, 4, 6, 8, 10, 15, 20, 50)
_LINK_EDGES_MS = (0, 0.5, 1, 1.5, 2, 3, 5, 10, 20)

_FIGURES: tuple[tuple[str, Callable[[SessionCurves], Figure | None], str], ...] = (
    (
        "Modes over time",
        modes_figure,
        "Upper band: the true mode, from the noise-free motion and force of the simulated finger. Lower band: what "
        "the remote site identified. Names above: the object touched.",
    ),
    (
        "Vibration",
        vibration_figure,
        "Blue is true: the speed of the simulated module's motor. Yellow is what the operator site commanded; a motor "
        "takes time to follow. Below the dashed line a vibration is not felt.",
    ),
    (
        "Plate and skin temperature",
        temperature_figure,
        "Blue and black are true: the simulated plate, and the skin under it. Dashed orange is the set-point that left "
        "the operator site; dotted red is the site's own model of what a finger on the real object would feel.",
    ),
    (
        "Identification converging",
        convergence_figure,
        "The remote site's own belief since contact: the probability of its likeliest material, and the object's "
        "temperature with its standard deviation. The thick black line is the true temperature; a dot marks the moment "
        f"a material was named. Touches shorter than 1 s are left out; at most {MOST_TOUCHES} are shown.",
    ),
    (
        "Force",
        force_figure,
        "Black and blue are true, at the simulated devices; yellow is the force that the remote site measured. Right: "
        "the largest of each beside its limit.",
    ),
)
_CONTACTS = (
    "<p>Contacts of at least 1 s. The true material and temperature are those of the simulated object; the rest is "
    "what the remote site told when the contact ended. The paper's answer is that of its own method (Kron &amp; "
    "Schmidt 2003, Eq. 11) on the same data.</p>"
)
_TRUE = (
    "<p>“True” is what happened in the simulated world, at the simulated devices. Everything else is what a site "
    "measured, believed or commanded.</p>"
)
_ACTED = "<p>How long each limit of a gate acted on a finger since both sites engaged:</p>"
_GROOVES = "<p>Impulses shown to the operator against grooves that the true fingertip crossed.</p>"
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def write_report(data: SessionData, summary: Mapping[str, Any], out: Path) -> None:
    """Write the session as one HTML file: tables and figures, no network, no script.

    Args:
        data: the merged recording; streams may be empty.
        summary: what `summary.json` holds; parts that are missing are said to be.
        out: file to write.

    Raises:
        OSError: `out` cannot be written.
    """
    session = SessionCurves.of(data, summary.get("fingers", len(FINGERS)))
    with mpl.rc_context(STYLE):
        figures = "".join(_section(title, _figure(title, draw(session), told)) for title, draw, told in _FIGURES)
    out.write_text(_page(session, summary, figures), "utf-8")


def write_figure(data: SessionData, out_png: Path, finger: str = "index") -> None:
    """Write the picture of one finger over the session, 1600 x 1000 pixels.

    Raises:
        ValueError: no such finger.
        OSError: `out_png` cannot be written.
    """
    if finger not in FINGERS:
        raise ValueError(f"finger {finger!r}: choose one of {', '.join(FINGERS)}")
    with mpl.rc_context(STYLE):
        out_png.write_bytes(_png(session_figure(SessionCurves.of(data), FINGERS.index(finger)), 100))


def _page(session: SessionCurves, summary: Mapping[str, Any], figures: str) -> str:
    contacts = summary.get("contacts") or []
    modes, taps = summary.get("modes") or {}, summary.get("taps") or {}
    agreement = (
        f"<p>Agreement over the whole time {_percent(modes.get('agreement'))}, "
        f"while in contact {_percent(modes.get('agreement_in_contact'))}.</p>"
    )
    delays = "".join(
        histogram_table(times_s, edges, name)
        for times_s, edges, name in (
            (contact_to_motor_s(session.data), _CONTACT_EDGES_MS, "contact to motor command"),
            (one_way_s(session.data), _LINK_EDGES_MS, "touch packet, one way"),
        )
    )
    felt = f"<p>Taps: {shown(taps.get('made'))} made, {shown(taps.get('played'))} played.</p>"
    cores = f"<p>All processes together: {shown(summary.get('cpu_cores'))} cores.</p>"
    latency = latency_table(summary.get("latency_ms") or {}) + f'<div class="side">{delays}</div>'
    parts = (
        _section("Contacts", _CONTACTS + tally_table(contacts) + contacts_table(contacts)),
        figures,
        _section("Limits", extremes_table(summary) + _ACTED + acted_table(session)),
        _section("Latency", latency),
        _section("Modes identified", agreement + confusion_table(modes)),
        _section("Grooves and taps", _GROOVES + impulses_table(summary.get("impulses") or {}) + felt),
        _section("Link", packets_table(summary.get("packets") or {})),
        _section("Loops, CPU and memory", process_table(summary) + cores),
    )
    title = f"Session: {shown(summary.get('scene'))}, seed {shown(summary.get('seed'))}"
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f"<title>{title}</title><style>{CSS}</style></head>\n"
        f"<body><h1>{title}</h1>{_header(summary)}{''.join(parts)}</body></html>\n"
    )


def _header(summary: Mapping[str, Any]) -> str:
    contacts = summary.get("contacts") or []
    words = [verdict(contact.get("material"), contact.get("true_material")) for contact in contacts]
    latency = ((summary.get("latency_ms") or {}).get("contact_to_motor") or {}).get("p50")
    facts = {
        "duration": f"{shown(summary.get('duration_s'), 1)} s",
        "fingers": shown(summary.get("fingers")),
        "contacts": f"{len(words)}: " + ", ".join(f"{words.count(w)} {w}" for w in ("right", "wrong", "no answer")),
        "modes agree": _percent((summary.get("modes") or {}).get("agreement")),
        "contact to motor, median": "–" if latency is None else f"{shown(latency, 1)} ms",
        "faults": _faults(summary.get("faults") or []),
    }
    listed = "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in facts.items())
    return f"<dl>{listed}</dl>{_TRUE}"


def _faults(faults: list[Any]) -> str:
    told = [f"{f.get('site')}: {f.get('fault')}" if isinstance(f, Mapping) else str(f) for f in faults]
    return f'<span class="fault">{escape("; ".join(told))}</span>' if told else NONE


def _section(title: str, content: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{content}</section>\n"


def _figure(title: str, figure: Figure | None, told: str) -> str:
    if figure is None:
        return f"<p>{NONE}</p>"
    source = base64.b64encode(_png(figure, _DPI)).decode("ascii")
    return (
        f'<figure><img alt="{escape(title)}" src="data:image/png;base64,{source}">'
        f"<figcaption>{escape(told)}</figcaption></figure>"
    )


def _png(figure: Figure, dpi: int) -> bytes:
    buffer = BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.1f} %"
