"""Reads the unfinished examination of an earlier run of the console, so that the next run can continue it."""

import glob
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgpack
from mcap.records import Channel, Message, Metadata

from common.privacy.recording_file import open_recording
from common.recording.truncated_mcap import TruncatedMcap

log = logging.getLogger(__name__)

Entry = tuple[int, str, dict[str, Any]]
"""Time in ns of the machine's monotonic clock, stream and record."""
_STREAMS = ("console/session", "console/finding", "console/felt")


@dataclass(frozen=True, slots=True)
class Unfinished:
    """An examination that an earlier run began and did not end.

    Attributes:
        files: its recordings, oldest first.
        records: stream and record of its begin, its findings and its samples of the map, in order of time.
        cut_off: its study number if the machine was restarted since; empty otherwise. It cannot be continued then,
            because the restart reset the monotonic clock.
    """

    files: tuple[Path, ...] = ()
    records: tuple[tuple[str, dict[str, Any]], ...] = ()
    cut_off: str = ""

    @property
    def findings(self) -> set[int]:
        """Numbers of the findings; a damaged record has none."""
        idents = (record.get("id") for stream, record in self.records if stream == "console/finding")
        return {ident for ident in idents if isinstance(ident, int)}


def unfinished(path: Path, now: str) -> Unfinished:
    """Return the unfinished examination in `PATH` or in files of its name with `-` and any suffix.

    Those files are the successors -1, -2 ..., and files that a supervisor has set aside before a restart.

    Args:
        path: path of the first file.
        now: identifier of this boot, `boot_id()`.
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
        return Unfinished()
    since = entries[sessions[-1] :]
    same = bool(now) and newest == now
    return Unfinished(
        tuple(dict.fromkeys(file for _, file in since)),
        tuple((stream, record) for (_, stream, record), _ in since),
        "" if same else str(since[0][0][2].get("pseudonym")),
    )


def _read(path: Path) -> tuple[str, list[Entry]]:
    """Return the boot identifier of a file and its entries of examinations; a truncated file yields what is left."""
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
    with open_recording(path) as file:
        for record in TruncatedMcap(file).records():
            match record:
                case Metadata(name="session"):
                    yield record.metadata.get("boot", "")
                case Channel():
                    topics[record.id] = record.topic
                case Message() if topics.get(record.channel_id) in _STREAMS:
                    yield record.log_time, topics[record.channel_id], dict(msgpack.unpackb(record.data))
