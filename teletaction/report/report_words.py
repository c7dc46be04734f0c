"""Writes a session's numbers as HTML tables; right and wrong are words as well as colours."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import htpy as h
from htpy import Element, Node

from common.faults.texts import thermal_text
from common.wire.messages import THERMAL_REASONS, ExplorationMode
from operator_site.console.examination.findings import UNCERTAIN_SD_K, UNIT, signed, with_sd
from operator_site.console.map.roughness_shown import roughness_shown
from teletaction.recordings.machine_verdict import WHAT_HELD_MEANS

NONE = "none"
_RIGHT, _WRONG, _SILENT = "right", "wrong", "no answer"


def shown(value: Any, digits: int = 2) -> str:
    """Return a value as text; a dash for an unknown value."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{digits}f}"
    return str(value)


def cells(entry: Mapping[str, Any], *names: str) -> list[Node]:
    """Return the values of these names as text."""
    return [shown(entry.get(name)) for name in names]


def table(head: Sequence[str], rows: Iterable[Sequence[Node]], name: str | None = None) -> Element:
    """Write a table; "none" without rows."""
    body = [h.tr[[h.td[cell] for cell in row]] for row in rows]
    if not body:
        return h.p[NONE]
    titles = h.thead[h.tr[[h.th(scope="col")[title] for title in head]]]
    return h.div(".wide")[h.table[name and h.caption[name], titles, h.tbody[body]]]


def verdict(answer: Any, true: Any) -> str:
    """Return whether an answer names the true material: right, wrong or no answer."""
    if answer is None:
        return _SILENT
    return _RIGHT if answer == true else _WRONG


def _judged(contact: Mapping[str, Any], name: str) -> Node:
    """Write an answer with its verdict."""
    answer = contact.get(name)
    word = verdict(answer, contact.get("true_material"))
    sign = {_RIGHT: "✓", _WRONG: "✗", _SILENT: "–"}[word]
    mark = h.span(class_=word.replace(" ", "-"))[f"{sign}\u00a0{word}"]
    return mark if answer is None else [shown(answer), " ", mark]


def targets_table(targets: Sequence[Mapping[str, Any]]) -> Element:
    """Write the table of the targets of a simulated scene, with the errors of place and value."""
    head = ("target", "stands out in", "found beside its place (mm)", "felt", "around it", "true", "error")
    rows: list[list[str]] = []
    for target in targets:
        row = [shown(target.get("target")), shown(target.get("quantity"))]
        if target.get("value") is None:
            rows.append([*row, "not felt", "–", "–", "–", "–"])
            continue
        value, sd = target["value"], target["sd"]
        around, true, error = (target.get(name) for name in ("around", "true_value", "error"))
        unit = UNIT.get(str(target.get("quantity")))
        if unit is None:  # roughness; a simulated surface has no true one in the sensor's unit
            around = None if around is None else roughness_shown(around, around, None).value
            value, sd, unit = roughness_shown(value, sd, None)
        rows.append(
            [
                *row,
                shown(target["place_error_mm"], 1),
                f"{with_sd(value, sd)} {unit}",
                "–" if around is None else f"{around:.3g} {unit}",
                "–" if true is None else f"{true:g} {unit}",
                "–" if error is None else f"{signed(error, sd)} {'K' if unit == '°C' else unit}",
            ]
        )
    return table(head, rows)


def lumps_table(lumps: Sequence[Mapping[str, Any]]) -> Element:
    """Write the table of the lumps on the map, and of nodules of a simulated scene."""
    head = ("place (mm)", "size (mm)", "stiffness ratio", "probability", "true nodule", "true size (mm)", "off by (mm)")
    rows: list[list[Node]] = []
    for lump in lumps:
        row: list[Node] = ["not found", "–", "–", "–"]
        if lump["probability"] is not None:
            edge = [" ", h.small["(at the edge of the map)"]] if lump["at_edge"] else None
            row = [
                [f"{shown(lump['x_mm'], 1)}, {shown(lump['y_mm'], 1)}", edge],
                f"{shown(lump['length_mm'], 1)} × {shown(lump['width_mm'], 1)}",
                with_sd(lump["stiffness_ratio"], lump["stiffness_ratio_sd"]),
                f"{lump['probability']:.2f}",
            ]
        rows.append([*row, *(shown(lump[name]) for name in ("nodule", "true_size_mm", "place_error_mm"))])
    return table(head, rows)


def contacts_table(contacts: Sequence[Mapping[str, Any]]) -> Element:
    """Write the table of contacts, with the true and the identified values."""
    head = ["finger", "object", "true material", "identified", "status", "likeliest", "probability", "named after (s)"]
    head += ["held (s)", "object, true (°C)", "estimated (°C)", "paper's answer"]
    rows = []
    for contact in contacts:
        status, reason, spread = shown(contact.get("status")), contact.get("reason"), contact.get("object_c_sd")
        rows.append(
            [
                *cells(contact, "finger", "object", "true_material"),
                _judged(contact, "material"),
                [status, " ", h.small[f"({_why(reason)})"]] if reason else status,
                *cells(contact, "best", "probability", "seconds", "held_s", "true_object_c"),
                shown(contact.get("object_c")) + _plus_minus(spread),
                _judged(contact, "paper_material"),
            ]
        )
    return table(head, rows)


def _plus_minus(spread: Any) -> str:
    """Write the standard deviation of an object's temperature, K; empty if unknown."""
    if spread is None:
        return ""
    return f"\u00a0±\u00a0{shown(spread)}" + (", uncertain" if spread > UNCERTAIN_SD_K else "")


def tally_table(contacts: Sequence[Mapping[str, Any]]) -> Element:
    """Count for each true material the right, wrong and missing answers of this system and of the paper's method."""
    rows, verdicts = [], (_RIGHT, _WRONG, _SILENT)
    for true in dict.fromkeys(contact.get("true_material") for contact in contacts):
        mine = [contact for contact in contacts if contact.get("true_material") == true]
        cells = [shown(true), str(len(mine))]
        for answer in ("material", "paper_material"):
            words = [verdict(contact.get(answer), true) for contact in mine]
            cells += [str(words.count(word)) for word in verdicts]
        rows.append(cells)
    return table(["true material", "contacts", *verdicts, *(f"paper: {word}" for word in verdicts)], rows)


def confusion_table(modes: Mapping[str, Any]) -> Element:
    """Write the table of true modes by row and identified ones by column, counted every 10 ms."""
    confusion: Mapping[str, Mapping[str, int]] = modes.get("confusion") or {}
    words = {mode.name.lower(): mode.word for mode in ExplorationMode}
    rows: list[list[Node]] = []
    for true, row in confusion.items():
        total = sum(row.values())
        cells = [h.b[row.get(name, 0)] if name == true else row.get(name, 0) for name in words]
        rows.append(
            [
                f"true {words.get(true, shown(true))}",
                *cells,
                f"{100 * row.get(true, 0) / total:.1f} %" if total else "–",
            ]
        )
    return table(["", *(f"identified {word}" for word in words.values()), "agreement"], rows)


def impulses_table(impulses: Mapping[str, Any]) -> Element:
    """Write the table of grooves that the true fingertips crossed and of displayed impulses, by object and in all."""
    counts = ("crossed", "played", "edges", "missed", "invented")
    rows: list[list[Node]] = [
        [shown(thing), *cells(row, *counts)] for thing, row in (impulses.get("by_object") or {}).items()
    ]
    if any(impulses.get(name) for name in counts) or rows:
        rows.append([h.b["all"], *(h.b[shown(impulses.get(name))] for name in counts)])
    return table(("object", *counts), rows)


def histogram_table(times_s: Sequence[float], edges_ms: Sequence[float], name: str) -> Element:
    """Write a histogram of delays between the edges, as numbers with bars."""
    if not times_s:
        return h.p[f"{name}: {NONE}"]
    edges = [float("-inf"), *edges_ms, float("inf")]
    counts = [sum(low <= 1e3 * t < high for t in times_s) for low, high in pairwise(edges)]
    between = [f"{low:g} to {high:g}" for low, high in pairwise(edges_ms)]
    labels = [f"below {edges_ms[0]:g}", *between, f"{edges_ms[-1]:g} and more"]
    used = [place for place, count in enumerate(counts) if count]
    rows: list[list[Node]] = [
        [label, count, h.span(".bar", style=f"width:{160 * count / max(counts):.0f}px")]
        for label, count in list(zip(labels, counts, strict=True))[used[0] : used[-1] + 1]
    ]
    return table(("ms", "count", ""), rows, name)


def latency_table(latency_ms: Mapping[str, Any]) -> Element:
    """Write the table of the session's delays and of a bare ping of the same size in the same run, ms."""
    names = {
        "contact_to_motor": "contact at the sensor to motor command in the module",
        "link_one_way": "touch packet, from its source time until its rendering left for the modules",
        "bare_curve_ping": "bare CURVE ping of the same size, there and back",
    }
    rows = [
        [names.get(key) or shown(key), *cells(row, "p50", "p99", "max", "count")]
        for key, row in latency_ms.items()
        if row
    ]
    return table(("delay (ms)", "median", "99 %", "largest", "count"), rows)


def process_table(summary: Mapping[str, Any]) -> Node:
    """Write the table of lateness, CPU and memory of each process."""
    loops: Mapping[str, Any] = summary.get("loop") or {}
    memory: Mapping[str, Any] = summary.get("rss_mib") or {}
    fields = ("period_ms", "ticks", "late_p50_us", "late_p99_us", "late_max_us", "missed", "behind_s", "cpu")
    rows = []
    for name in dict.fromkeys((*loops, *memory)):
        loop = loops.get(name) or {}
        cells = [shown(loop.get(part), 3 if part == "cpu" else 1) for part in fields]
        rows.append([shown(name), *cells, shown(memory.get(name), 1)])
    head = (
        "process",
        "period (ms)",
        "ticks",
        "late, median (µs)",
        "late, 99 % (µs)",
        "late, largest (µs)",
        "ticks missed",
        "rate not held (s)",
        "CPU (cores)",
        "memory (MiB)",
    )
    return [table(head, rows), h.p[WHAT_HELD_MEANS]]


def packets_table(packets: Mapping[str, Any]) -> Element:
    """Write the table of the counters of both ends of the link."""
    counts = ("sent", "received", "superseded", "refused")
    return table(("stream", *counts), ([shown(name), *cells(row, *counts)] for name, row in packets.items()))


def _why(code: object) -> str:
    """Return the text of a thermal reason's code; the code itself if it comes from another version."""
    reason = THERMAL_REASONS.get(str(code))
    return str(code) if reason is None else thermal_text(reason)
