"""Makes the state of a page: everything it shows beside pictures and tiles, as JSON."""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from common.faults.fault import OF_THE_PATIENT
from common.fingers import FINGER_Y_M, FINGERS
from common.wire.messages import NO_TOUCH, STIFFNESS_KNOWN_LN_SD, ThermalReason, ThermalStatus, TouchRow
from common.wire.packets import LinkState
from operator_site.console import texts
from operator_site.console.alarms.alarm_rules import DISK_NEARLY_FULL, unconfirmed
from operator_site.console.alarms.alarms import Alarm
from operator_site.console.camera.camera_now import CameraNow
from operator_site.console.camera.still_picture import can_decode
from operator_site.console.examination.contrast import contrast_of, contrast_text
from operator_site.console.examination.examination import Finding
from operator_site.console.examination.findings import UNCERTAIN_SD_K
from operator_site.console.map.map_layer import CELL_M
from operator_site.console.map.map_tiles import RANGES
from operator_site.console.map.tactile_map import COLUMNS, QUANTITIES, ROWS, ExploredPlace, Measured
from operator_site.console.model import Console
from operator_site.console.state.fingers_now import GONE_S
from operator_site.console.state.site_now import DEVICES, SILENT_S
from operator_site.console.tenderness.pain_presses import ANSWER_OLD_S
from operator_site.console.tenderness.tender_search import CIRCLE_SD

_MOST_ALARMS = 50
DECIDE_AT = 0.995
"""Probability from which the remote site names a material."""


def page_state(
    console: Console,
    now_s: float,
    is_saved: Callable[[int], bool],
    operator: str,
    origin_s: float | None = None,
    wall_clock: Callable[[float], str] | None = None,
) -> dict[str, Any]:
    """Return the state that is common to all pages.

    Args:
        console: the console's model.
        now_s: time, s of the operator site's clock.
        is_saved: returns whether a finding is on the disk.
        operator: name of the operator site's configuration file, for advice.
        origin_s: origin of the times of alarms and findings, s; by default the begin of the examination.
        wall_clock: formats a time of the site's clock, s, as the time of day; None where it is unknown.
    """
    site = console.site
    from_s = (console.examination.began_s or now_s) if origin_s is None else origin_s
    return {
        "session": _session(console, now_s),
        "link": site.link.shown(now_s),
        "alarms": [_alarm(alarm, now_s, from_s, wall_clock) for alarm in console.alarms.listed[:_MOST_ALARMS]],
        "fingers": [
            console.calm.step(now_s, finger, finger_state(console, finger, now_s)) for finger in range(len(FINGERS))
        ],
        "devices": [_device(console, name, operator) for name in DEVICES],
        "checks": checks(console, now_s, operator),
        "stop": _stop(console, now_s),
        "engage": {"wanted": site.wanted, "refusal": refusal(console)},
        "coupling": {"open": site.coupling.open, "scale": site.coupling.scale, "edges": site.edges},
        "patient": _patient(console, now_s),
        "map": _map(console),
        "findings": [
            finding_state(finding, is_saved(finding.ident), from_s) for finding in console.examination.findings.values()
        ],
        "undo": _undo(console),
        "changes": len(console.examination.undoable),
        "meaning": site.calibrated or None,
        "decide_at": DECIDE_AT,
        "camera": None if console.around.camera is None else camera_state(console.around.camera),
        "voice": None if console.around.voice is None else asdict(console.around.voice),
    }


def camera_state(now: CameraNow) -> dict[str, Any]:
    """Return what the camera shows for a page."""
    return {"seen": now.seen, "reduced": now.reduced, "stills": can_decode()}


def refusal(console: Console) -> str:
    """Return why engaging would be refused now; empty if it would not."""
    site = console.site
    absent = [name for name, ready in site.ready.items() if not ready]
    if site.remote_fault and site.remote_fault.code in OF_THE_PATIENT:
        return texts.PATIENT_STOPS
    if site.state is LinkState.FAULT or site.remote_fault:
        return texts.FAULT_NOT_CLEARED
    if absent:
        return texts.CANNOT_ENGAGE.format(why=texts.device_absent(absent[0]))
    if site.refusal and not site.session:  # in a session, it is of an earlier request
        return texts.short(texts.CANNOT_ENGAGE.format(why=site.refusal))
    if console.around.camera is not None and console.around.camera.holds:
        return texts.CAMERA_NEEDED
    return "" if console.around.sound else texts.NOT_SOUNDED


def _session(console: Console, now_s: float) -> dict[str, Any]:
    began_s, pseudonym = console.examination.began_s, console.examination.pseudonym
    return {
        "state": console.word(now_s),
        "why": texts.capital(console.site.paused or ""),
        "clock_s": None if pseudonym is None or began_s is None else round(max(0.0, now_s - began_s), 1),
        "pseudonym": pseudonym,
        "recording": console.recording,
        "saved": None,
        "playback": None,
        "sound": console.around.sound or None,
        "body": None if console.examination.body is None else console.examination.body.text(),
        "consented": console.consent.agreed or (),
    }


def _alarm(alarm: Alarm, now_s: float, from_s: float, wall_clock: Callable[[float], str] | None) -> dict[str, Any]:
    over = alarm.waits or alarm.ended_s is not None
    return {
        "id": alarm.ident,
        "priority": alarm.cause.priority.name.lower(),
        "text": alarm.text,
        "what": alarm.cause.text,
        "since_s": round(alarm.since_s - from_s, 2),
        "since": None if wall_clock is None else wall_clock(alarm.since_s),
        "age_s": round(now_s - alarm.since_s, 1),
        "active": not over,
        "waits": alarm.waits,
        "ended_s": None if alarm.gone_s is None or not over else round(alarm.gone_s - from_s, 2),
        "cleared_by": alarm.cleared_by,
        "quiet_until_s": _rounded(alarm.quiet_until_s, 1),
        "silenceable": alarm.cause.silenceable,
    }


def finger_state(console: Console, finger: int, now_s: float) -> dict[str, Any]:
    """Return what is known of one finger and its object; None stands for unknown and for too old."""
    fingers, name = console.fingers, FINGERS[finger]
    age_s = fingers.age_s(now_s)
    fresh = age_s <= GONE_S
    row = fingers.rows[finger] if fresh else NO_TOUCH
    since_s = fingers.contact_since_s[finger] if fresh else None
    touching = since_s is not None
    summary = fingers.summaries[finger]
    status = ThermalStatus(int(row.thermal_status)) if touching else ThermalStatus.NO_CONTACT
    material = fingers.touch.materials[finger] if fingers.touch is not None and touching else ""
    reason = ThermalReason(int(row.thermal_reason))
    word, line = texts.decision(status, reason, material, summary, row.probability)
    known_c = touching and row.object_c_sd < 10.0 and status > ThermalStatus.NO_CONTACT
    stiffness = row.stiffness_n_m if touching else 0.0
    return {
        "name": name,
        "in_use": console.in_use[finger],
        "contact_s": round(now_s - since_s, 2) if since_s is not None else None,
        "decision": word,
        "line": line,
        "candidates": [[texts.named(name), round(p, 4)] for name, p in summary.candidates] if touching else [],
        "object_c": round(row.object_c, 2) if known_c else None,
        "object_c_sd": round(row.object_c_sd, 3) if known_c else None,
        "object_c_uncertain": bool(known_c and row.object_c_sd > UNCERTAIN_SD_K),
        "stiffness_n_m": round(stiffness, 1) if stiffness > 0.0 else None,
        "stiffness_sd_n_m": round(stiffness * row.stiffness_ln_sd, 1) if stiffness > 0.0 else None,
        "stiffness_known": bool(stiffness > 0.0 and row.stiffness_ln_sd < STIFFNESS_KNOWN_LN_SD),
        "roughness_v": _rounded(summary.roughness_v, 5) if touching else None,
        "roughness_sd_v": _rounded(summary.roughness_sd_v, 5) if touching else None,
        "groove_mm": _mm(summary.groove_m) if touching else None,
        "groove_sd_mm": _mm(summary.groove_sd_m) if touching else None,
        "against": _against(console, finger, row, now_s) if touching else {},
        "limits": fingers.limits(finger, now_s) if console.in_use[finger] else [],
        "softened": console.in_use[finger] and fingers.softened(finger, now_s),
        "age_s": _rounded(age_s, 3),
    }


def _against(console: Console, finger: int, row: TouchRow, now_s: float) -> dict[str, str]:
    """Return the contrast of a finger's object with the surroundings on the map, in words, where it is known."""
    x_m, y_m = row.x_m, row.y_m + FINGER_Y_M[finger]
    warm = row.object_c_sd < UNCERTAIN_SD_K and row.thermal_status > ThermalStatus.NO_CONTACT
    stiff = row.stiffness_n_m > 0.0 and row.stiffness_ln_sd < STIFFNESS_KNOWN_LN_SD
    here = ExploredPlace(
        x_m,
        y_m,
        temperature=Measured(row.object_c, row.object_c_sd, 1, now_s) if warm and row.object_c_sd > 0.0 else None,
        roughness=None,
        stiffness=Measured(row.stiffness_n_m, row.stiffness_n_m * row.stiffness_ln_sd, 1, now_s) if stiff else None,
        material=None,
    )
    around = console.tactile_map.around(x_m, y_m)
    found = [contrast_of(kind, here, around) for kind in ("warm", "stiff")]
    return {differs.quantity: differs.text() for differs in found if differs is not None}


def checks(console: Console, now_s: float, operator: str) -> list[dict[str, Any]]:
    """Return the check list of a session without the devices: each item is ready or has its remedy."""
    site, around = console.site, console.around
    doctor = f"teletaction doctor --config {operator}"
    answers = site.silent_s(now_s) <= SILENT_S or not console.live
    connected = answers and site.session != 0
    link = site.link.shown(now_s)
    measured = link["delay_ms"] is not None
    used = texts.DISK_USED.format(percent=around.disk_used * 100)
    consent = console.consent
    found = [
        _check("operator site", answers, texts.START_SITE, f"teletaction operator --config {operator}"),
        _check(
            "calibration",
            connected and bool(site.calibrated),
            texts.NOT_CALIBRATED if connected else f"{texts.capital(texts.NO_REMOTE_SITE)}.",
            "teletaction calibrate thermal --traces DIR --out TABLE" if connected else doctor,
        ),
        _check("link", measured or connected, texts.NO_REMOTE_DATA, doctor),
    ]
    if site.refusal:
        found.insert(1, _check("remote site", False, texts.capital(site.refusal), doctor))
    if not console.live:  # disk, sound and consent of this console are not those of the recording
        return found
    found += [
        _check("disk", around.disk_used < DISK_NEARLY_FULL, used, "df -h"),
        _check("sound", bool(around.sound), texts.SOUND_NOT_HEARD, texts.PLAY_SOUND)
        | ({"text": texts.NO_SOUND} if around.sound == "refused" else {}),
    ]
    if consent.agreed is not None:
        text = texts.consents_differ(consent.here, consent.there, consent.agreed)
        found.append(_check("consent", not consent.differs, text, texts.SAME_CONSENT))
    return found


def _device(console: Console, name: str, operator: str) -> dict[str, Any]:
    site = console.site
    if site.ready and name not in site.ready:
        return {"name": name, "ready": True, "text": texts.NOT_USED, "help": ""}
    why = f" {site.whys[name]}." if name in site.whys else ""
    text = texts.short(texts.device_absent(name) + why)
    return _check(name, site.ready.get(name, False), text, f"teletaction doctor --config {operator}")


def _check(name: str, ready: bool, text: str, remedy: str) -> dict[str, Any]:
    return {"name": name, "ready": ready, "text": "" if ready else text, "help": "" if ready else remedy}


def _stop(console: Console, now_s: float) -> dict[str, Any] | None:
    site = console.site
    if site.stop_asked_s is None:
        return None
    after_s = site.stop_after_s
    return {
        "asked_s": round(site.stop_asked_s, 3),
        "devices": {name: _rounded(after_s[name], 3) for name in DEVICES if name in after_s},
        "confirmed": bool(after_s) and None not in after_s.values(),
        "late": bool(unconfirmed(now_s, site)),
    }


def _map(console: Console) -> dict[str, Any]:
    tactile_map = console.tactile_map
    left_m, near_m = tactile_map.frame
    scale = console.site.roughness_um
    ranges = {quantity: list(ends) for quantity, ends in RANGES.items()}
    return {
        "frame": {"x_m": left_m, "y_m": near_m, "cell_m": CELL_M, "columns": COLUMNS, "rows": ROWS},
        "legend": {quantity: list(tactile_map.legend(quantity)) for quantity in RANGES},
        "ranges": ranges,
        "number": console.map_number,
        "materials": [texts.named(name) for name in tactile_map.materials],
        "roughness_um": None if scale is None else scale._asdict() | {"holds_v": list(scale.holds_v)},
        "sides": console.examination.sides,
        "felt_mm": None if tactile_map.felt_m is None else [round(1e3 * edge_m, 1) for edge_m in tactile_map.felt_m],
        "felt_cells": {
            quantity: sum(layer.felt_cells for layer in tactile_map.layers_of(quantity)) for quantity in QUANTITIES
        },
        "lumps": [
            {name: lump[name] for name in ("x_mm", "y_mm", "probability", "stiffness_ratio", "at_edge", "outline_mm")}
            for lump in console.searched.lumps
        ],
        "next_mm": console.searched.next_mm,
        "moved": None if console.shift.movement is None else texts.moved(console.shift.movement.by_m),
        "stale_mm": [[round(1e3 * x_m), round(1e3 * y_m)] for x_m, y_m in tactile_map.stale()],
    }


def _patient(console: Console, now_s: float) -> dict[str, Any] | None:
    """Return the patient's pain, 0..10, or None while it is unknown or old; its age, s; and the force limit."""
    site = console.site
    if site.patient is None:
        return None
    age_s = max(0.0, now_s - site.patient_s) if console.live else 0.0  # a recording has changes only
    limit_n = site.patient.limit_n
    return {
        "pain": None if site.patient.pain is None or age_s > ANSWER_OLD_S else round(site.patient.pain, 1),
        "age_s": round(age_s, 1),
        "limit": None if limit_n is None else texts.FORCE_LIMITED.format(limit_n=limit_n),
        "ends": None if limit_n is None else texts.LIMIT_ENDS,
        "reports": [
            [round(1e3 * report.x_m, 1), round(1e3 * report.y_m, 1), round(report.threshold_n, 2), report.answer]
            for report in site.patient.reports
        ],
        "tender": _tender(console),
        "agreed": console.pain_agreed,
    }


def _tender(console: Console) -> dict[str, Any] | None:
    """Return the most tender place in words, and the circle that holds it with 95 %, mm; None before a report."""
    found = console.tenderness
    if not found.reports:
        return None
    at_mm = found.place_mm
    circle = None if at_mm is None else [*(round(along, 1) for along in at_mm[:2]), round(CIRCLE_SD * at_mm[2], 1)]
    return {
        "text": texts.tenderness(at_mm, found.known_threshold_n, found.known_reaction_s, alike=found.alike),
        "circle": circle,
    }


def _undo(console: Console) -> int | None:
    """Return the number of the finding that an undo would change; None without one."""
    examination = console.examination
    return examination.undoable[-1].ident if examination.pseudonym is not None and examination.undoable else None


def finding_state(finding: Finding, is_saved: bool, from_s: float) -> dict[str, Any]:
    """Return a finding for a page."""
    return {
        "id": finding.ident,
        "at_s": round(finding.at_s - from_s, 3),
        "kind": finding.kind,
        "finger": finding.finger,
        "x_mm": _mm(finding.x_m),
        "y_mm": _mm(finding.y_m),
        "text": finding.text,
        "compare": finding.compare,
        "contrast": contrast_text(finding.contrast),
        "confidence": finding.confidence,
        "body": None if finding.body is None else {**finding.body.record(), "text": finding.body.text()},
        "withdrawn": finding.withdrawn,
        "note": finding.note,
        "saved": is_saved,
    }


def urgent(state: Mapping[str, Any]) -> object:
    """Return the part of a state whose change is sent at once; the rest is sent four times a second."""
    session = state["session"]
    return (
        {name: value for name, value in session.items() if name not in ("clock_s", "playback")},
        [(alarm["id"], alarm["priority"], alarm["active"], alarm["waits"]) for alarm in state["alarms"]],
        [(finger["decision"], finger["limits"]) for finger in state["fingers"]],
        state["devices"],
        state["stop"],
        state["engage"],
        state["coupling"],
        state["camera"],
        state["voice"],
        state["findings"],
        state["map"]["frame"],
        state["map"]["number"],
    )


def _rounded(value: float | None, places: int) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, places)


def _mm(value_m: float | None) -> float | None:
    return None if value_m is None else round(value_m * 1e3, 3)
