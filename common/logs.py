"""Formats log lines on standard error: text for people, or one JSON object a line for a log collector."""

import json
import logging
import math
import os
import sys
import threading
import time
from datetime import UTC, datetime
from typing import Literal

from common.files.printable import LONGEST, printable, printable_lines
from common.log_flood import FloodFilter

LogForm = Literal["text", "json"]
LEVEL_VARIABLE = "TELETACTION_LOG"
"""Environment variable with the lowest level that is logged: one of LEVELS; INFO by default."""
LEVELS = ("debug", "info", "warning", "error")

_OF_EVERY_RECORD = frozenset(logging.makeLogRecord({}).__dict__) | {"message", "asctime", "taskName"}

_LONGEST_TRACE = 4 * LONGEST
"""Maximum length of an exception's text, characters; its start and its end are kept."""


class TextLines(logging.Formatter):
    """Text lines with a monotonic time that matches the times in recordings."""

    def __init__(self, process: str) -> None:
        super().__init__()
        self._process = process

    def format(self, record: logging.LogRecord) -> str:
        """Return monotonic time, s, process, level, logger, message, number of omitted lines, and any exception."""
        said = printable(record.getMessage())
        if left_out := getattr(record, "left_out", 0):
            said += f" ({left_out} similar lines omitted)"
        if record.exc_info:
            said += f": {printable(_cut(self.formatException(record.exc_info)), _LONGEST_TRACE)}"
        name = printable(record.name, 100)
        return f"{time.monotonic():.3f} {self._process} {record.levelname} {name}: {said}"


class JsonLines(logging.Formatter):
    """One JSON object a line; fields of a caller's `extra` stand beside the fields of every line."""

    def __init__(self, process: str) -> None:
        super().__init__()
        self._process = process

    def format(self, record: logging.LogRecord) -> str:
        """Return the line: time_utc, monotonic_s, level, process, logger, message, the context, and any exception."""
        context = {name: _plain(value) for name, value in record.__dict__.items() if name not in _OF_EVERY_RECORD}
        line: dict[str, object] = {
            **context,
            "time_utc": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "monotonic_s": round(time.monotonic(), 3),
            "level": record.levelname.lower(),
            "process": self._process,
            "logger": printable(record.name, 100),
            "message": printable(record.getMessage()),
        }
        if record.exc_info:
            line["exception"] = printable_lines(_cut(self.formatException(record.exc_info)))[:_LONGEST_TRACE]
        return json.dumps(line, ensure_ascii=False)


def log_to_stderr(process: str, form: LogForm = "text") -> None:
    """Send the log lines of this process to standard error; as JSON, unexpected exceptions and warnings, too.

    Raises:
        ValueError: the environment names an unknown level.
    """
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines(process) if form == "json" else TextLines(process))
    handler.addFilter(FloodFilter())
    logging.basicConfig(level=log_level(), handlers=[handler], force=True)
    quiet_libraries()
    if form == "json":
        logging.captureWarnings(True)
        root = logging.getLogger()
        sys.excepthook = lambda kind, value, trace: root.critical("unexpected", exc_info=(kind, value, trace))
        threading.excepthook = lambda failed: root.critical("unexpected", exc_info=failed.exc_value)


def log_level() -> int:
    """Return the lowest level that is logged, from the environment.

    Raises:
        ValueError: the environment names an unknown level.
    """
    name = os.environ.get(LEVEL_VARIABLE, "info").lower()
    if name not in LEVELS:
        raise ValueError(f"{LEVEL_VARIABLE}: no level {name!r}; choose one of {', '.join(LEVELS)}")
    return logging.getLevelNamesMapping()[name.upper()]


def quiet_libraries() -> None:
    """Silence libraries that log each failed connection and each part of a message; the lines log it once."""
    for library in ("can", "can.interfaces.socketcand"):
        logging.getLogger(library).setLevel(logging.CRITICAL)


def spoken(line: str) -> str:
    """Return the message of a log line of either form."""
    try:
        parsed = json.loads(line)
    except ValueError:
        return line
    if not isinstance(parsed, dict) or "message" not in parsed:
        return line
    return str(parsed["message"])


def _cut(trace: str) -> str:
    half = _LONGEST_TRACE // 2 - 10
    return trace if len(trace) <= 2 * half else f"{trace[:half]} ... {trace[-half:]}"


def _plain(value: object) -> object:
    """Return a value unchanged where JSON has its type; else as printable text."""
    if value is None or (isinstance(value, int) and value.bit_length() <= 64):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    try:
        return printable(str(value))
    except ValueError:  # an integer with more digits than Python prints
        return f"<{type(value).__name__}>"
