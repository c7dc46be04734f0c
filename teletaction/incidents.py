"""What went wrong in a session, by what both sites noted of it."""

from collections.abc import Container
from typing import Any

from teletaction.session_data import SessionData


def faults(data: SessionData) -> list[dict[str, Any]]:
    """Faults that latched and emergency stops: site, what, its words, and when, s from the first thing noted."""
    return _noted(data, ("fault", "estop"))


def interruptions(data: SessionData) -> list[dict[str, Any]]:
    """Silence of the far site, devices that went missing, and ends of work; told like `faults`."""
    return _noted(data, ("silent", "missing", "disconnected", "disengaged"))


def _noted(data: SessionData, kinds: Container[str]) -> list[dict[str, Any]]:
    start_s = min((entry["time_s"] for entry in data.happenings), default=0.0)
    return [
        {
            "site": entry["site"],
            "what": entry["what"],
            "fault": entry["text"],
            "time_s": round(entry["time_s"] - start_s, 2),
        }
        for entry in sorted(data.happenings, key=lambda entry: float(entry["time_s"]))
        if entry["what"] in kinds
    ]
