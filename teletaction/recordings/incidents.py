"""Lists faults, interruptions and incomplete recordings of a session from the events that both sites recorded."""

from collections.abc import Container, Mapping
from typing import Any

from teletaction.recordings.recording_loss import recording_loss
from teletaction.recordings.session_data import SessionData


def faults(data: SessionData) -> list[dict[str, Any]]:
    """Return latched faults and emergency stops: site, kind, text, code and time, s from the first recorded event."""
    return _noted(data, ("fault", "estop"))


def interruptions(data: SessionData) -> list[dict[str, Any]]:
    """Return what interrupted or changed the coupling of both hands, in the form of `faults`.

    These are silences of the far site, losses of devices, ends of engagement, and changes of clutch and motion scale.
    """
    return _noted(data, ("silent", "missing", "disconnected", "disengaged", "clutch", "scale"))


def incomplete_recordings(data: SessionData, statuses: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return recordings that stopped or lost messages, by the last status of each process, in the form of `faults`.

    The time is None if messages were lost and the recording did not stop.
    """
    found = []
    for name, status in statuses.items():
        words = recording_loss(status)
        if not words:
            continue
        stopped_ns = status.get("recording_failed_ns")
        at_s = None
        if stopped_ns is not None:
            at_s = round(stopped_ns * 1e-9 - data.leads_s.get(name, 0.0) - _start_s(data), 2)
        found.append({"site": name, "what": "recording", "fault": words, "time_s": at_s})
    return found


def _start_s(data: SessionData) -> float:
    """Return the time of the first recorded event, s."""
    return min((float(entry["time_s"]) for entry in data.happenings), default=0.0)


def _noted(data: SessionData, kinds: Container[str]) -> list[dict[str, Any]]:
    start_s = _start_s(data)
    return [
        {
            "site": entry["site"],
            "what": entry["what"],
            "fault": entry["text"],
            "code": entry["fault"] and entry["fault"][0],
            "time_s": round(entry["time_s"] - start_s, 2),
        }
        for entry in sorted(data.happenings, key=lambda entry: float(entry["time_s"]))
        if entry["what"] in kinds
    ]
