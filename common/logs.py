"""Log lines on standard error: for people, or one JSON object a line for a log collector."""

import json
import logging
import math
import sys
import threading
import time
from datetime import UTC, datetime
from typing import Literal

LogForm = Literal["text", "json"]

_OF_EVERY_RECORD = frozenset(logging.makeLogRecord({}).__dict__) | {"message", "asctime", "taskName"}


class _TextLines(logging.Formatter):
    """Lines with a monotonic time that fits the recordings' times."""

    def __init__(self, process: str) -> None:
        super().__init__(f"%(asctime)s {process} %(levelname)s %(name)s: %(message)s")

    def formatTime(self, record: logging.LogRecord, datefmt: str | None = None) -> str:
        return f"{time.monotonic():.3f}"


class JsonLines(logging.Formatter):
    """One JSON object a line; what a caller gave as `extra` stands beside the fields that every line has."""

    def __init__(self, process: str) -> None:
        super().__init__()
        self._process = process

    def format(self, record: logging.LogRecord) -> str:
        """The line: time_utc, monotonic_s, level, process, logger, message, the context, and an exception if any."""
        context = {name: _plain(value) for name, value in record.__dict__.items() if name not in _OF_EVERY_RECORD}
        line: dict[str, object] = {
            **context,
            "time_utc": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "monotonic_s": round(time.monotonic(), 3),
            "level": record.levelname.lower(),
            "process": self._process,
            "logger": record.name,
            "message": record.getMessage(),
        }
        if record.exc_info:
            line["exception"] = self.formatException(record.exc_info)
        return json.dumps(line, ensure_ascii=False)


def log_to_stderr(process: str, form: LogForm = "text") -> None:
    """Send all log lines of this process to standard error; as JSON, unexpected exceptions and warnings too."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines(process) if form == "json" else _TextLines(process))
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
    quiet_libraries()
    if form == "json":
        logging.captureWarnings(True)
        root = logging.getLogger()
        sys.excepthook = lambda kind, value, trace: root.critical("unexpected", exc_info=(kind, value, trace))
        threading.excepthook = lambda failed: root.critical("unexpected", exc_info=failed.exc_value)


def quiet_libraries() -> None:
    """Let those be silent that report each failed try to connect and each piece of a message; the lines say it once."""
    for library in ("can", "can.interfaces.socketcand"):
        logging.getLogger(library).setLevel(logging.CRITICAL)


def spoken(line: str) -> str:
    """What a log line of either form says."""
    try:
        told = json.loads(line)
    except ValueError:
        return line
    if not isinstance(told, dict) or "message" not in told:
        return line
    return str(told["message"])


def _plain(value: object) -> object:
    """As it is where JSON has it; else as text."""
    plain = value is None or isinstance(value, (str, int)) or (isinstance(value, float) and math.isfinite(value))
    return value if plain else str(value)
