"""Writes the report's tables of limits: extreme values, and the time that each limit acted on each finger."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from htpy import Element

from common.fingers import FINGERS
from common.limits import COMFORT, CONTACT_FORCE_N, FINGER_FORCE_N, MOTOR_FLOOR_RPM, PLATE_FAULT_C, SENSOR_PLATE_C
from operator_site.safety.limit_flags import Limit as OperatorLimit
from remote_site.safety.limit_flags import Limit as PatientLimit
from teletaction.recordings.session_data import Series
from teletaction.report.report_words import shown, table
from teletaction.report.session_curves import SessionCurves, held_s

SHORTEST_S = 0.1
"""Shortest time for which a limit acted that the first page names, s."""


def extremes_table(summary: Mapping[str, Any]) -> Element:
    """Write the table of extreme values at the simulated devices with their limits."""

    def value(name: str, end: str) -> str:
        return shown((summary.get(name) or {}).get(end))

    perceptible = f"felt above {MOTOR_FLOOR_RPM:g}"
    hottest = f"set to {COMFORT.high_c:g}; fault at {PLATE_FAULT_C:g}"
    rows = (
        ("operator's plate, highest (°C)", value("plate_c", "max"), hottest),
        ("operator's plate, lowest (°C)", value("plate_c", "min"), f"set to {COMFORT.low_c:g}"),
        ("sensor's plate on the patient, highest (°C)", value("sensor_plate_c", "max"), f"{SENSOR_PLATE_C:g}"),
        ("force at the operator's finger, largest (N)", value("force_n", "max"), f"{FINGER_FORCE_N:g}"),
        ("force on the patient, largest (N)", value("contact_force_n", "max"), f"{CONTACT_FORCE_N:g}"),
        ("motor while free, fastest (rpm)", value("vibration_rpm", "free_max"), perceptible),
        ("motor while resting, fastest (rpm)", value("vibration_rpm", "resting_max"), perceptible),
    )
    return table(("measured at the simulated devices", "value", "limit (comfort profile)"), rows)


def acted_table(session: SessionCurves) -> Element:
    """Write the table of times that each limit of both gates acted on each finger, s, since both sites engaged."""
    rows = [[site, name, *(_seconds(value) for value in seconds)] for site, name, seconds in acted(session)]
    return table(("gate", "limit", *(f"{FINGERS[finger]} (s)" for finger in session.fingers)), rows)


def reached(session: SessionCurves, from_s: float | None = None, to_s: float | None = None) -> str:
    """List the limits that acted for at least SHORTEST_S on a finger, with the longest time; name a missing gate.

    By default they acted from when both sites engaged to the end; times are s of the recording's clock.
    """
    missing = [site for site, series, _ in _gates(session) if not len(series)]
    if len(missing) == len(_gates(session)):
        return "The limits of both sites are not in this recording."
    found = [
        f"{name} ({site} site, {FINGERS[session.fingers[seconds.index(max(seconds))]]} {max(seconds):.1f} s)"
        for site, name, seconds in acted(session, from_s, to_s)
        if name != "released" and max(seconds) >= SHORTEST_S
    ]
    known = "".join(f" of the {site} site" for site, _, _ in _gates(session) if missing and site not in missing)
    said = (
        f"Limits that acted, each with its longest time on a finger: {', '.join(found)}."
        if found
        else f"No limit{known} acted."
    )
    return said + "".join(f" The limits of the {site} site are not in this recording." for site in missing)


def acted(
    session: SessionCurves, from_s: float | None = None, to_s: float | None = None
) -> list[tuple[str, str, list[float]]]:
    """Return each limit that acted: the gate's site, the limit's name, and its time on each finger, s.

    It counts since both sites engaged, and from `from_s` to `to_s` where given, s of the recording's clock.
    """
    begin_s, end_s = max(session.zero_s, -math.inf if from_s is None else from_s), math.inf if to_s is None else to_s
    found = []
    for site, series, limits in _gates(session):
        bits = series.values.get("limits")
        if bits is None or bits.ndim != 2:
            continue
        within = (series.time_s >= begin_s) & (series.time_s < end_s)
        lasted_s = np.where(within, held_s(series.time_s), 0.0)
        flags = np.where(np.isfinite(bits), bits, 0.0).astype(int)
        for limit in limits:
            seconds = [float(lasted_s[(flags[:, finger] & limit.value) != 0].sum()) for finger in session.fingers]
            if any(seconds):
                found.append((site, str(limit.name).lower().replace("_", " "), seconds))
    return found


def _gates(session: SessionCurves) -> tuple[tuple[str, Series, type[OperatorLimit] | type[PatientLimit]], ...]:
    """Return site, recorded output and limits of each gate."""
    return ("operator", session.data.rendered, OperatorLimit), ("patient", session.data.gate, PatientLimit)


def _seconds(value: float) -> str:
    return "< 0.01" if 0.0 < value < 0.01 else shown(value)
