"""What an earlier run of the console kept: an examination that it left under way is gone on with by the next."""

import glob
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgpack
from mcap.records import Channel, Message, Metadata

from common.recording.truncated_mcap import TruncatedMcap

log = logging.getLogger(__name__)

Entry = tuple[int, str, dict[str, Any]]
"""Time, ns of the machine's monotonic clock, stream and record."""
_STREAMS = ("console/session", "console/finding", "console/felt")


@dataclass(frozen=True, slots=True)
class KeptBefore:
    """An examination that was begun and not ended.

    Attributes:
        files: those that hold it, oldest first.
        records: stream and record of its begin, of its findings and of what was felt, in order of time.
        cut_off: its study number, where the machine was restarted since: then it cannot be gone on with, for its
            times are of a clock that began anew.
    """

    files: tuple[Path, ...] = ()
    records: tuple[tuple[str, dict[str, Any]], ...] = ()
    cut_off: str = ""

    @property
    def findings(self) -> set[int]:
        """Their numbers."""
        return {record["id"] for stream, record in self.records if stream == "console/finding"}


def boot() -> str:
    """Names this run of the machine, whose monotonic clock means nothing in another; empty where that is not told."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
    except OSError:
        return ""


def kept_before(path: Path, now: str) -> KeptBefore:
    """The examination that was left under way in `PATH`, or in files of its name with `-` and anything more.

    Those are its successors, -1, -2 ..., and what a supervisor has set aside before a restart.

    Args:
        path: of the first file.
        now: this run of the machine, `boot()`.
    """
    named = (glob.escape(path.name), f"{glob.escape(path.stem)}-*{path.suffix}")
    files = [file for name in named for file in path.parent.glob(name)]
    contents = {file: _read(file) for file in sorted(files, key=lambda file: (file.stat().st_mtime_ns, file.name))}
    newest = next((made for made, _ in reversed(contents.values()) if made), "")
    entries = sorted(
        ((entry, file) for file, (made, found) in contents.items() if made == newest for entry in found),
        key=lambda item: item[0][0],
    )
    sessions = [place for place, ((_, stream, _), _) in enumerate(entries) if stream == "console/session"]
    if not sessions or entries[sessions[-1]][0][2].get("what") != "begin":
        return KeptBefore()
    since = entries[sessions[-1] :]
    same = bool(now) and newest == now
    return KeptBefore(
        tuple(dict.fromkeys(file for _, file in since)),
        tuple((stream, record) for (_, stream, record), _ in since),
        "" if same else str(since[0][0][2].get("pseudonym")),
    )


def _read(path: Path) -> tuple[str, list[Entry]]:
    """In which run of the machine a file was made, and what it has of examinations; a cut one has what it has."""
    made, entries = "", []
    try:
        for item in _items(path):
            if isinstance(item, str):
                made = item
            else:
                entries.append(item)
    except (OSError, ValueError, TypeError) as error:
        log.warning("%s: %s", path, error)
    return made, entries


def _items(path: Path) -> Iterator[str | Entry]:
    topics: dict[int, str] = {}
    with path.open("rb") as file:
        for record in TruncatedMcap(file).records():
            match record:
                case Metadata(name="session"):
                    yield record.metadata.get("boot", "")
                case Channel():
                    topics[record.id] = record.topic
                case Message() if topics.get(record.channel_id) in _STREAMS:
                    yield record.log_time, topics[record.channel_id], dict(msgpack.unpackb(record.data))
