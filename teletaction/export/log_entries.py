"""Puts faults, changes of the session, notes and findings into words, as entries of a log."""

from typing import Any

from common.faults.texts import said_fault
from teletaction.export.named_fields import Named, Schema
from teletaction.export.named_recording import NamedMessage

_INFO, _WARNING, _ERROR = 2, 3, 4
_LEVELS = {"fault": _ERROR, "estop": _ERROR, "silent": _WARNING, "missing": _WARNING}
TIMESTAMP_SCHEMA: Schema = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
LOG_SCHEMA: Schema = {
    "type": "object",
    "properties": {
        "timestamp": TIMESTAMP_SCHEMA,
        "level": {"type": "integer"},
        "message": {"type": "string"},
        "name": {"type": "string"},
    },
}
"""Schema of `foxglove.Log`."""


def log_entry(message: NamedMessage) -> Named | None:
    """Return the entry for a message, as `foxglove.Log` has it; None for a message that is no event for a person."""
    level, text = _words(message.topic, message.fields)
    if not text:
        return None
    return {"timestamp": timestamp(message.wall_ns), "level": level, "message": text, "name": message.topic}


def timestamp(wall_ns: int) -> Named:
    """Return a wall-clock time, ns since 1970, as Foxglove has it."""
    seconds, nanoseconds = divmod(wall_ns, 10**9)
    return {"sec": seconds, "nsec": nanoseconds}


def _words(topic: str, fields: dict[str, Any]) -> tuple[int, str]:
    match topic:
        case "remote/session" | "operator/session":
            what = str(fields["what"])
            return _LEVELS.get(what, _INFO), ": ".join(
                filter(None, (what, fields["text"] or said_fault(fields["fault"])))
            )
        case "remote/note":
            return _INFO, str(fields.get("text", ""))
        case "console/finding":
            return _INFO, _noted("withdrawn" if fields.get("withdrawn") else "", fields)
        case "console/alarm":
            ended = fields.get("ended_s") is not None
            return (_INFO, _noted("ended", fields)) if ended else (_WARNING, _noted("", fields))
        case "truth_event":
            return _INFO, f"{fields['finger']}: {fields['kind']} {fields['object']}"
    return _INFO, ""


def _noted(change: str, fields: dict[str, Any]) -> str:
    text = str(fields.get("text", ""))
    return f"{change}: {text}" if change and text else text
