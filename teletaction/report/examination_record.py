"""Writes the technical record of a session: devices, calibration, link, alarms, faults, audit trail, versions."""

import json
from collections.abc import Mapping
from typing import Any

import htpy as h
import numpy as np
from htpy import Element, Node

from common.version import software_version
from operator_site.console.map.tactile_map import QUANTITIES
from teletaction.recordings.session_data import SessionData
from teletaction.recordings.summary import one_way_s
from teletaction.report.examination import Examination
from teletaction.report.examination_page import confidence, covered_by, place_of
from teletaction.report.report_parts import section
from teletaction.report.report_words import cells, shown, table


def record(examination: Examination, data: SessionData, summary: Mapping[str, Any]) -> Node:
    """Write the record, with every number of the examination as JSON."""
    zero_s = _zero_s(data, examination)
    return [
        section("Devices", _devices(examination)),
        section("Calibration", _calibration(examination)),
        section("Link quality", _link(examination, data)),
        section("Alarms and faults", [_alarms(examination, zero_s), _faults(data, zero_s)]),
        section("Audit trail", _acts(examination, zero_s)),
        section("Versions, and how to replay", _versions(examination)),
        section("Every number", _json(numbers(examination, data, summary)), "screen"),
    ]


def numbers(examination: Examination, data: SessionData, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the report's numbers for programs to read."""
    tactile_map = examination.felt
    coverage = {quantity: covered_by(examination, quantity) for quantity in QUANTITIES}
    return {
        "examination": examination.begun or None,
        "ended_s": examination.ended_s,
        "findings": [
            {
                **finding,
                "confidence": confidence(examination, finding),
                "felt_by_the_end": None if (here := place_of(examination, finding)) is None else _place(here),
            }
            for finding in examination.findings.values()
        ],
        "coverage": {
            quantity: None
            if covered is None
            else {"felt_m2": covered.felt_m2, "explored_m2": covered.explored_m2, "lines_m": covered.lines_m}
            for quantity, covered in coverage.items()
        },
        "scales": {quantity: tactile_map.legend(quantity) for quantity in QUANTITIES[:3]},
        "materials": tactile_map.materials,
        "link": _link_numbers(examination, data),
        "alarms": list(examination.alarms.values()),
        "acts": list(examination.acts.values()),
        "tables": examination.tables,
        "configurations": examination.configurations(),
        "unreadable_messages": dict(examination.damaged),
        "session": dict(summary),
    }


def _place(here: Any) -> dict[str, Any]:
    values = {name: getattr(here, name) for name in ("temperature", "roughness", "stiffness")}
    return {name: None if value is None else value._asdict() for name, value in values.items()} | {
        "material": here.material
    }


def _devices(examination: Examination) -> Element:
    """Write the operator site's last figures of each of its devices."""
    devices = examination.figures.get("devices")
    rows = []
    for name, status in devices.items() if isinstance(devices, Mapping) else ():
        if not isinstance(status, Mapping):
            continue
        words = ("times_lost", "damaged", "missed", "repeated", "malformed", "unsent", "unknown")
        counts = {word: status.get(word) for word in words}
        said = ", ".join(
            f"{word.replace('_', ' ')} {shown(count)}" for word, count in counts.items() if count is not None
        )
        rows.append([shown(name), shown(status.get("serial")), said])
    return table(("device of the operator site", "serial number", "counted"), rows)


def _calibration(examination: Examination) -> Element:
    rows = [
        [*cells(each, "name", "kind", "made_on", "sensor_serial", "touches"), h.small(".hash")[shown(each["hash"])]]
        for each in examination.tables
    ]
    return table(("table", "kind", "made on", "sensor", "touches or strokes", "hash"), rows)


def _link_numbers(examination: Examination, data: SessionData) -> dict[str, Any]:
    """Return delay and its uncertainty, ms, and the numbers of packets received and not received."""
    delays_ms = 1e3 * np.array(one_way_s(data))
    sequences = np.array(examination.sequences, dtype=np.float64)
    steps = np.diff(sequences)
    onward = steps[steps > 0]
    runs = 1 + np.count_nonzero(steps < 0)  # a restarted site counts from the start again
    sent = float(onward.sum()) + runs if len(sequences) else 0.0
    clock = np.array(examination.clock, dtype=np.float64).reshape(-1, 3)
    return {
        "delay_ms": None
        if not len(delays_ms)
        else {name: float(np.quantile(delays_ms, q)) for name, q in (("p50", 0.5), ("p99", 0.99), ("max", 1.0))},
        "clock_uncertainty_ms": float(1e3 * np.median(clock[:, 1])) if len(clock) else None,
        "round_trip_ms": float(1e3 * np.median(clock[:, 2])) if len(clock) else None,
        "touch_packets": len(sequences),
        "superseded_or_lost": max(0, round(sent) - len(sequences)),
        "longest_gap_packets": int(onward.max()) - 1 if len(onward) else None,
    }


def _link(examination: Examination, data: SessionData) -> Element:
    values = _link_numbers(examination, data)
    delay = values["delay_ms"] or {}
    spread = values["clock_uncertainty_ms"]
    rows = [
        [
            f"touch packet to command, {name} (ms)",
            shown(delay.get(key)) + ("" if spread is None else f" ± {spread:.2f}"),
        ]
        for name, key in (("median", "p50"), ("99 %", "p99"), ("longest", "max"))
        if key in delay
    ]
    rows += [
        [name, shown(values[key])]
        for name, key in (
            ("round trip, median (ms)", "round_trip_ms"),
            ("touch packets received", "touch_packets"),
            ("superseded by a newer one, or lost", "superseded_or_lost"),
            ("largest number lost in a row", "longest_gap_packets"),
        )
    ]
    if examination.clocks:
        offset_s, bound_s = (1e-9 * int(examination.clocks[name]) for name in ("offset_ns", "uncertainty_p95_ns"))
        rows.append(["clock of the remote host, ahead (s), with 95 % bound", f"{offset_s:+.6f} ± {bound_s:.6f}"])
    return table(("", "value"), rows)


def _alarms(examination: Examination, zero_s: float) -> Node:
    rows = [
        [
            _time(alarm.get("since_s"), zero_s),
            *cells(alarm, "priority", "text"),
            _time(alarm.get("ended_s"), zero_s),
            shown(alarm.get("cleared_by")),
        ]
        for alarm in examination.alarms.values()
    ]
    return [h.h3["Alarms"], table(("at (s)", "priority", "what", "ended (s)", "cleared by"), rows)]


def _faults(data: SessionData, zero_s: float) -> Node:
    rows = [[_time(entry.get("time_s"), zero_s), *cells(entry, "site", "what", "text")] for entry in data.happenings]
    return [h.h3["Session events of both sites"], table(("at (s)", "site", "what", ""), rows)]


def _acts(examination: Examination, zero_s: float) -> Element:
    rows = [
        [
            _time(act.get("at_s"), zero_s),
            *cells(act, "who", "verb"),
            h.small(".hash")[shown(_short(act.get("details")))],
            "not answered" if act.get("ok") is None else "yes" if act["ok"] else "refused",
            shown(act.get("answer")),
        ]
        for act in examination.acts.values()
    ]
    return table(("at (s)", "who", "act", "details", "done", "answer"), rows)


def _versions(examination: Examination) -> Node:
    rows = [
        [shown(origin), shown(facts.get("version")), h.small(".hash")[hashed]]
        for origin, hashed in examination.configurations().items()
        for facts in (examination.facts[origin],)
    ]
    damaged = sum(examination.damaged.values())
    return [
        table(("recorded by", "version", "hash of its configuration"), rows),
        h.p[f"This report: version {software_version()}."],
        h.p[f"Messages that could not be read: {damaged}."] if damaged else None,
        h.p[
            "To see the session again: ",
            h.code["teletaction console --play session.mcap"],
            ". To identify and render again from the recorded sensor data: ",
            h.code["teletaction replay session.mcap --out FOLDER"],
            ". This report: ",
            h.code["teletaction report session.mcap --out FILE.html"],
            ".",
        ],
    ]


def _json(values: dict[str, Any]) -> Element:
    written = json.dumps(values, indent=1, ensure_ascii=False, default=str, allow_nan=True)
    return h.details[h.summary["As JSON"], h.pre[written]]


def _time(at_s: Any, zero_s: float) -> str:
    return f"{float(at_s) - zero_s:.1f}" if isinstance(at_s, int | float) else "–"


def _short(details: Any) -> str | None:
    if not details:
        return None
    text = json.dumps(details, ensure_ascii=False, default=str)
    return text if len(text) <= 200 else text[:199] + "…"


def _zero_s(data: SessionData, examination: Examination) -> float:
    """Return the time at which both sites first engaged; else that of the first packet or the examination's start."""
    engaged = np.flatnonzero(data.rendered.values.get("engaged", np.empty(0)) > 0)
    if len(engaged):
        return float(data.rendered.time_s[engaged[0]])
    return float(data.touch.time_s[0]) if len(data.touch) else float(examination.begun.get("at_s", 0.0))
