"""Recognises the files that the project writes about an examination, by name and content."""

import os
import re
import stat
from collections.abc import Callable
from pathlib import Path

from common.files.private_file import PART
from common.recording.encrypted_file import MAGIC as ENCRYPTED
from common.recording.mcap_records import HEAD_BYTES
from common.recording.mcap_records import MAGIC as MCAP
from teletaction.export.columns import TIME_COLUMNS, table_name
from teletaction.export.fhir import REPORT
from teletaction.export.foxglove_layout import LAYOUT
from teletaction.export.topics import TOPICS
from teletaction.mapping.write_map import COLUMNS as MAP_COLUMNS
from teletaction.report.pdf import MARK as PDF_MARK
from teletaction.report.report import GENERATOR

_START_BYTES = 1 << 16
_END_BYTES = 64
_PROCESS = (
    r"(remote|operator|sim-remote|sim-operator|console|camera|voice|patient-page|network|virtual|tunnel|rendezvous)"
    r"(-\d+)?"
)
_LOG_LINE = re.compile(rb"\d\.\d+ \S+ (DEBUG|INFO|WARNING|ERROR|CRITICAL) |^teletaction: ", re.MULTILINE)
"""Part of a line of text that a process logs, or start of the line with which it fails."""
_TABLES = frozenset(map(table_name, TOPICS))


def kind_of(path: Path) -> str | None:
    """Return what a file is, such as `recording`; None where it is no file of the project, a link, or unreadable."""
    try:
        number = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return None
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        return None
    with open(number, "rb") as file:
        start = file.read(_START_BYTES)
        file.seek(max(0, file.seek(0, 2) - _END_BYTES))
        end = file.read()
    name = PART.sub("", path.name)
    return next((kind for kind, test in _KINDS if test(name, start, end)), None)


_Test = Callable[[str, bytes, bytes], bool]
"""Judges a file by its name, its first _START_BYTES and its last _END_BYTES."""


def _named(pattern: str, *needed: bytes) -> _Test:
    """Return a test of a name and of texts that the file's start has."""
    names = re.compile(pattern)
    return lambda name, start, _: bool(names.fullmatch(name)) and all(text in start for text in needed)


def _recording(_name: str, start: bytes, _end: bytes) -> bool:
    """Return whether the header of an MCAP file names this program as its library."""
    head = start[len(MCAP) + HEAD_BYTES :]
    profile = int.from_bytes(head[:4], "little")
    return start.startswith(MCAP) and head[4 + profile :].startswith(b"\x0b\x00\x00\x00teletaction")


def _table(name: str, start: bytes, _end: bytes) -> bool:
    stem, _, suffix = name.rpartition(".")
    begins = {"csv": ",".join(TIME_COLUMNS).encode() + b",", "parquet": b"PAR1"}
    return stem in _TABLES and suffix in begins and start.startswith(begins[suffix])


def _log(name: str, start: bytes, _end: bytes) -> bool:
    """Return whether a file with the name of a log is empty or has a line of a process."""
    return bool(re.fullmatch(rf"({_PROCESS}|summarise)\.log", name)) and (not start or bool(_LOG_LINE.search(start)))


_KINDS: tuple[tuple[str, _Test], ...] = (
    ("encrypted file", lambda _name, start, _end: start.startswith(ENCRYPTED)),
    ("recording", _recording),
    ("report", lambda _name, start, _end: GENERATOR.encode() in start),
    ("report", lambda _name, start, end: start.startswith(b"%PDF-") and end.endswith(PDF_MARK)),
    ("summary", _named(r"summary\.json", b'"duration_s"', b'"contacts"')),
    ("export", _table),
    ("export", _named(r"findings\.fhir\.json", b'"Bundle"', REPORT.encode())),
    ("export", _named(r"findings\.dcm", b"DICM", b"teletaction")),
    ("export", _named(r"session\.rrd", b"RRF", b"teletaction")),
    ("export", lambda _name, start, _end: start == LAYOUT),
    ("map", _named(r"map\.csv", ",".join(MAP_COLUMNS).encode())),
    ("map", _named(r"map\.json", b'"presses"', b'"next_press_mm"')),
    ("map", _named(r"map\.png", b"\x89PNG", b"Matplotlib")),
    ("replay", _named(r"replay\.json", b'"recording"', b'"remote"', b'"ticks"')),
    ("replay", _named(r"identification\.jsonl", b'"finger"', b'"object_c_sd"')),
    ("replay", _named(r"rendering\.csv", b"time_s,", b"_motor_rpm,")),
    ("status", _named(_PROCESS + r"\.json", b'"process"', b'"rss_mib"')),
    ("status", _named(r"launcher\.json", b'"usage"', b'"round_trips_s"')),
    ("log", _log),
    ("log", _named(_PROCESS + r"\.log", b'"monotonic_s"', b'"logger"')),
    ("log", _named(r"summarise\.log", b"summary.json, report ")),
)
