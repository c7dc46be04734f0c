"""Messages of a site to its console, made by hand."""

from typing import Any

import msgpack

from common.faults.fault import Fault
from common.fingers import FINGERS
from common.link.session_state import Happening
from common.wire.messages import NO_TOUCH, ThermalStatus, Touch, pack_rows
from common.wire.packets import LinkState
from common.wire.touch_summary import NOTHING, TouchSummary
from operator_site.console.model import Console

S = 1_000_000_000
INDEX = 1
SUMMARY = TouchSummary((("pvc", 0.91), ("acrylic", 0.05)), 0.12, 0.01, 4e-3, 1e-4)
TOUCHING = {
    "mode": 2.0,
    "contact": 1.0,
    "contact_force_n": 1.5,
    "x_m": 0.01,
    "y_m": 0.02,
    "stiffness_n_m": 800.0,
    "stiffness_ln_sd": 0.03,
    "object_c": 24.1,
    "object_c_sd": 0.3,
    "probability": 0.91,
    "thermal_status": float(ThermalStatus.IDENTIFIED),
}


def touch(sequence: int, time_ns: int, summary: TouchSummary = SUMMARY, **values: float) -> bytes:
    """A touch packet of the index finger."""
    rows = [NO_TOUCH._replace(**TOUCHING | values) if finger == INDEX else NO_TOUCH for finger in range(len(FINGERS))]
    names, summaries = ("", "pvc", "", "", ""), (NOTHING, summary, NOTHING, NOTHING, NOTHING)
    return Touch(7, sequence, time_ns, LinkState.ENGAGED, pack_rows(rows), names, (), summaries).encode()


def rendered(engaged: bool = True, gap_s: float | None = 0.004, limited: int = 0, **each: float) -> bytes:
    """A tick's output, the same for all fingers."""

    def five(name: str, usual: float) -> list[float]:
        return [each.get(name, usual)] * len(FINGERS)

    row: list[Any] = [engaged, gap_s, five("force_n", 1.0), five("motor_rpm", 6000.0), five("plate_set_c", 30.0)]
    row += [five("peltier", 0.0), [limited] * len(FINGERS), None, 0.01, 0.02, five("z_m", 0.0), five("plate_c", 31.0)]
    return bytes(msgpack.packb([*row, 1, 0.0]))


def figures(**given: Any) -> bytes:
    """Of the status file, with two fingers in use and all there."""
    devices = {name: {"missing": ""} for name in ("exoskeleton", "index tacttip", "middle tacttip")}
    usual = {"state": "engaged", "fault": None, "devices": devices, "session": 7, "recorded": {"operator/touch": 5}}
    return bytes(msgpack.packb(usual | given))


def happen(console: Console, at_s: float, what: str, text: str = "", fault: Fault | None = None) -> None:
    console.take("operator/session", round(at_s * S), Happening(what, 7, text, fault).pack())


def fed(console: Console, from_s: float, to_s: float, **values: float) -> None:
    """A site at work, ticking at 100 Hz."""
    for n in range(round(from_s * 100), round(to_s * 100)):
        at_ns = n * S // 100
        console.take("operator/touch", at_ns, touch(n, at_ns - 20_000_000, **values))
        console.take("operator/rendered", at_ns, rendered())
        if n % 5 == 0:
            console.take("operator/skin", at_ns, msgpack.packb([[33.0] * 5, [31.0] * 5, [0.0] * 5]))
            console.take("operator/clock", at_ns, msgpack.packb([0, 2_000_000, 40_000_000]))
        if n % 100 == 0:
            console.take("operator/figures", at_ns, figures())
