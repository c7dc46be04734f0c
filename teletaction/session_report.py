"""The report of a session made anew from its recording."""

import json
from pathlib import Path
from typing import Any

from teletaction.examination import Examination
from teletaction.recorded_session import RecordedSession
from teletaction.report import write_report
from teletaction.session_data import SessionData


def report(recording: Path, out: Path) -> None:
    """Write it; `summary.json` beside the recording gives the figures that are of the processes.

    Raises:
        ValueError: it is no whole recording, or the summary beside it is no JSON object.
        OSError: a file cannot be read or written.
    """
    with recording.open("rb") as file:
        RecordedSession(recording, file)
    write_report(
        SessionData.read(recording), _summary(recording.with_name("summary.json")), out, Examination.read(recording)
    )


def _summary(path: Path) -> dict[str, Any]:
    if not path.exists():
        return {}
    try:
        summary = json.loads(path.read_text("utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: not JSON: {error}") from None
    if not isinstance(summary, dict):
        raise ValueError(f"{path}: expected an object")
    return summary
