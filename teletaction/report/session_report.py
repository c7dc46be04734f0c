"""Writes the report of a session from its recording."""

import logging
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypedDict

import msgspec

from common.files.read_files import read_json
from teletaction.recordings.merge import merge_recordings
from teletaction.recordings.session_data import SessionData
from teletaction.report.examination import Examination
from teletaction.report.pdf import print_pdf
from teletaction.report.report import write_report

log = logging.getLogger(__name__)

_Maps = dict[str, dict[str, Any] | None] | None
_Numbers = dict[str, float | None] | None


class _Summary(TypedDict, total=False):
    """Types of what a report reads of a `summary.json`."""

    duration_s: float | None
    fingers: int | None
    contacts: list[dict[str, Any]] | None
    targets: list[dict[str, Any]] | None
    lumps: list[dict[str, Any]] | None
    modes: dict[str, float | dict[str, dict[str, int]] | None] | None
    impulses: dict[str, int | _Maps] | None
    taps: _Numbers
    vibration_rpm: _Numbers
    latency_ms: dict[str, _Numbers] | None
    plate_c: _Numbers
    sensor_plate_c: _Numbers
    force_n: _Numbers
    contact_force_n: _Numbers
    loop: dict[str, _Numbers] | None
    recorded: dict[str, int] | None
    rss_mib: _Numbers
    packets: _Maps
    faults: list[Any] | None


def report(recordings: Sequence[Path], out: Path, *, blur: bool = False) -> None:
    """Write the report. A `summary.json` beside the first recording supplies the figures of the processes.

    One of other recordings, such as that of an earlier session, is left out with a warning.

    Args:
        recordings: one merged recording, or those of a session's processes, which may still be running.
        out: HTML file to write, or a PDF, which Chromium prints without the technical annex.
        blur: cover the camera's pictures outside the surroundings of the marks.

    Raises:
        ValueError: a recording is truncated or damaged, the summary is of another form, no PDF can be printed, or
            `out` is one of the recordings or the summary.
        OSError: a file cannot be read or written.
    """
    if out.exists() and any(out.samefile(recording) for recording in recordings):
        raise ValueError(f"{out}: is a recording to report on; name another file with --out")
    beside = recordings[0].with_name("summary.json")
    if out.exists() and beside.exists() and out.samefile(beside):
        raise ValueError(f"{out}: is the summary to report on; name another file with --out")
    summary = _summary(beside)
    with TemporaryDirectory() as folder:
        merged = recordings[0]
        if len(recordings) > 1:
            merged = Path(folder) / "session.mcap"
            merge_recordings(list(recordings), merged)
        data = SessionData.read(merged)
        if not _is_of(summary, data):
            log.warning("%s: is of other recordings; left out", beside)
            summary = {}
        pdf = out.suffix.lower() == ".pdf"
        html = Path(folder) / "report.html" if pdf else out
        write_report(data, summary, html, Examination.read(merged, blur=blur))
        if pdf:
            print_pdf(html, out)


def _is_of(summary: dict[str, Any], data: SessionData) -> bool:
    """Return whether a summary counts as many messages of each recorded stream; one without counts is accepted."""
    recorded = summary.get("recorded")
    return recorded is None or all(recorded.get(stream) == count for stream, count in data.counts.items())


def _summary(path: Path) -> dict[str, Any]:
    if not path.exists():
        return {}
    try:
        summary = read_json(path)
        msgspec.convert(summary, _Summary)
    except msgspec.ValidationError as error:
        raise ValueError(f"{path}: not a summary of a session: {error}") from None
    except ValueError as error:
        raise ValueError(f"{path}: not JSON: {error}") from None
    return dict(summary)
