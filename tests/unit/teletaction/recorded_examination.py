"""A small recording with a console: a warm spot, findings with hostile notes, acts, an alarm."""

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import msgpack

from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.recording.recorder import Recorder
from common.wire.messages import NO_TOUCH, ThermalStatus, Touch, pack_rows
from common.wire.packets import LinkState
from common.wire.touch_summary import NOTHING, TouchSummary

HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(1)> & \"quotes\" 'and' \u202eleft \u0000 " + "x" * 10_000
NOTES = {
    "script": HOSTILE,
    "long": "a word and " * 900 + "an end",
    "controls": "".join(map(chr, range(32))) + "\x7f\x80\x9f\u2028",
    "terminal": "\x1b[2J\x1b]0;title\x07 \x1b$B escaped charset",
    "lines": "first line\nsecond line\r\nthird \\ backslash ^ = & | ~ \t tab",
    "html": "</text></div>&lt;b&gt; <![CDATA[ x ]]> <!-- y -->",
    "right to left": "כתוב בעברית, مكتوب بالعربية \u202e\u2066 override",
    "emoji": "👩\u200d🔬 🖐🏽 é e\u0301 𝔘 \U0010ffff",
    "nul": "before\x00after",
    "blanks": " \n\t ",
    "worst": "\U000f0000" * 10_000,
}
"""Notes that have broken programs before, each as long as the console allows or shorter, but for the first."""
START_S = 5000.0
WALL_CLOCK = "2026-11-23T14:07:03+01:00"
INDEX = FINGERS.index("index")
PLACES_M = [(x, y) for y in (0.0, 0.006, 0.012) for x in (0.0, 0.006, 0.012, 0.018, 0.024)]
TOUCH_S = 2.0
LUMP_M = (0.020, 0.020)
"""Middle of the lump of `record_lump`, m."""
_STREAMS = ("operator/touch", "operator/clock", "operator/figures", "operator/session")
_CONSOLE = ("console/session", "console/finding", "console/act", "console/alarm")


def record(out: Path, *, console: bool = True, note: str = HOSTILE) -> Path:
    """The index finger rests on 15 places, 35 °C on the middle one and 33 °C on the others; returns the recording."""
    streams = {name: {} for name in (*_STREAMS, *(_CONSOLE if console else ()))}
    with Recorder(
        out, streams, {"configuration": "rate_hz = 500.0\n"}, {"materials.json": b'{"kind": "k"}'}
    ) as recorder:
        sequence = 0
        for number, (x_m, y_m) in enumerate(PLACES_M):
            for tick in range(round(1.2 * TOUCH_S / 0.1)):
                sequence += 1
                now_ns = round(1e9 * (START_S + 1.2 * TOUCH_S * number + 0.1 * tick))
                packet = touch_of(sequence, now_ns, x_m, y_m, contact=0.1 * tick < TOUCH_S, warm=number == 7)
                recorder.write("operator/touch", now_ns, packet.encode())
        recorder.write("operator/clock", now_ns, msgpack.packb([0, 900_000, 46_000_000]))
        figures = {"devices": {HOSTILE[:40]: {"serial": "TT0001", "times_lost": 3}}}
        recorder.write("operator/figures", now_ns, msgpack.packb(figures))
        fault = Fault(FaultCode.CONTAINED, detail=HOSTILE[:60])
        recorder.write("operator/session", now_ns, msgpack.packb(["fault", 1, "", fault]))
        for stream, entry in _at_the_console(note) if console else ():
            recorder.write(stream, now_ns, msgpack.packb(entry))
    return out


def begin_of(at_s: float) -> bytes:
    """The record of an examination's begin."""
    return bytes(msgpack.packb(_begun(at_s, "P-0419")))


def _begun(at_s: float, pseudonym: str, **known: Any) -> dict[str, Any]:
    """An examination's begin, of which only `known` is known."""
    unknown = {"wall_clock": None, "who": None, "sides": {}}
    return {"what": "begin", "at_s": at_s, "pseudonym": pseudonym} | unknown | known


def _found(number: int, at_s: float, text: str, **known: Any) -> dict[str, Any]:
    """A finding of the index finger without a place, unless `known` has one."""
    nowhere = {"kind": "stiff", "finger": "index", "x_m": None, "y_m": None}
    return {"id": number, "at_s": at_s, "text": text, "compare": None, "note": None} | nowhere | known


def record_empty(out: Path) -> Path:
    """A session without a console, so without an examination and findings."""
    return record(out, console=False)


def record_findings(out: Path, findings: Iterable[dict[str, Any]], pseudonym: str = "P-0418", **begun: Any) -> Path:
    """Findings one second apart, of the index finger on an unexplored bench; returns the recording."""
    with Recorder(out, {"console/session": {}, "console/finding": {}}, {}) as recorder:
        recorder.write("console/session", 10**9, msgpack.packb(_begun(1.0, pseudonym, **begun)))
        for number, finding in enumerate(findings, 1):
            found = _found(number, 1.0 + number, f"stiff {number}") | finding
            recorder.write("console/finding", 10**9 * (1 + number), msgpack.packb(found))
    return out


def record_lump(out: Path) -> Path:
    """Presses every 4 mm over a lump of twice the stiffness, three findings, and a withdrawn one; returns the file."""
    with Recorder(out, {name: {} for name in (*_STREAMS, *_CONSOLE)}, {"configuration": ""}) as recorder:
        now_ns = round(1e9 * START_S)
        for number, (x_m, y_m) in enumerate((4e-3 * x, 4e-3 * y) for x in range(10) for y in range(10)):
            lift = math.exp(-((math.dist((x_m, y_m), LUMP_M) / 6e-3) ** 2))
            stiffness_n_m = 600.0 * (1.0 + 0.02 * math.sin(7.0 * number)) * 2.0**lift
            for tick in range(8):
                now_ns += 50_000_000
                how = {"contact": tick < 6, "warm": number > 80, "stiffness_n_m": stiffness_n_m}
                packet = touch_of(8 * number + tick + 1, now_ns, x_m, y_m, **how)
                recorder.write("operator/touch", now_ns, packet.encode())
        for stream, entry in _of_a_lump():
            recorder.write(stream, now_ns, msgpack.packb(entry))
    return out


def record_notes(out: Path) -> Path:
    """One finding for each of NOTES, in their order."""
    return record_findings(out, ({"text": note[:50], "note": note} for note in NOTES.values()))


def record_many(out: Path) -> Path:
    """500 findings, at places that no decimal number of 16 characters describes."""
    return record_findings(out, ({"x_m": number / 7000.0, "y_m": -number / 3e5} for number in range(500)))


def touch_of(
    sequence: int, now_ns: int, x_m: float, y_m: float, *, contact: bool, warm: bool, stiffness_n_m: float = 600.0
) -> Touch:
    """A touch packet with the index finger at a place, m."""
    known = {
        "contact": 1.0,
        "mode": 2.0,
        "stiffness_n_m": stiffness_n_m,
        "stiffness_ln_sd": 0.03,
        "object_c": 35.0 if warm else 33.0,
        "object_c_sd": 0.2,
        "thermal_status": float(ThermalStatus.IDENTIFIED),
    }
    rows = [NO_TOUCH] * len(FINGERS)
    rows[INDEX] = NO_TOUCH._replace(x_m=x_m, y_m=y_m + 0.02, **(known if contact else {}))
    summaries = [NOTHING] * len(FINGERS)
    summaries[INDEX] = TouchSummary((("<i>skin_dermis</i>", 0.99),)) if contact else NOTHING
    return Touch(1, sequence, now_ns, LinkState.ENGAGED, pack_rows(rows), ("",) * len(FINGERS), (), tuple(summaries))


def _of_a_lump() -> list[tuple[str, dict[str, Any]]]:
    """An examination with a place on the body, three findings, and one that was withdrawn."""
    body = {"region": "forearm", "side": "left", "landmark": "wrist crease", "landmark_mm": 80.0}
    places = (("stiff", LUMP_M), ("warm", (0.036, 0.008)), ("soft", (0.004, 0.030)), ("stiff", (0.030, 0.030)))
    texts = ("stiff, 1150 ± 30 N/m", "warm, 35.0 ± 0.2 °C", "soft, 602 ± 15 N/m", "stiff, 611 ± 15 N/m")
    compare = "1.91 ± 0.05 times the 602 ± 15 N/m around it (9 touches)"
    findings = [
        _found(number, START_S + 2.0 * number, text, kind=kind, x_m=x_m, y_m=y_m)
        | {"compare": compare, "note": "", "withdrawn": ""}
        for number, ((kind, (x_m, y_m)), text) in enumerate(zip(places, texts, strict=True), 1)
    ]
    findings[0]["note"] = "moves with the skin"
    findings[3]["withdrawn"] = "pressed twice, no difference"
    return [
        ("console/session", _begun(START_S, "P-0419", wall_clock=WALL_CLOCK, who="OR-1", body=body)),
        *(("console/finding", found) for found in findings),
        ("console/session", {"what": "end", "at_s": START_S + 61.0, "pseudonym": "P-0419"}),
    ]


def _at_the_console(note: str) -> list[tuple[str, dict[str, Any]]]:
    compare = "+2.0 ± 0.3 K against 33.0 ± 0.2 °C around it (8 touches)"
    warm = {"kind": "warm", "x_m": 0.012, "y_m": 0.006, "compare": compare, "note": ""}
    found = _found(1, START_S + 18.0, "warm, 35.0 ± 0.2 °C", **warm)
    moment = _found(2, START_S + 5.0, "a moment", kind=None, finger="ring", compare="", note="")
    sides = {"top": "head", "right": "left"}
    return [
        ("console/session", _begun(START_S, "P-0417", wall_clock=WALL_CLOCK, who="OR-1", sides=sides)),
        ("console/finding", found),
        ("console/finding", found | {"note": note}),
        ("console/finding", moment),
        (
            "console/act",
            {"at_s": START_S, "who": HOSTILE[:50], "verb": "estop", "details": {"a": HOSTILE}, "ok": False},
        ),
        (
            "console/alarm",
            {"id": "plate", "since_s": START_S, "priority": "high", "text": HOSTILE[:60], "ended_s": None},
        ),
        ("console/finding", {"nonsense": 1}),
        ("console/session", {"what": "end", "at_s": START_S + 61.0, "pseudonym": "P-0417"}),
    ]
