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

Written = tuple[int, str, bytes]
"""Time in ns of the site's clock, stream and packed record."""
Entry = tuple[Written, dict[str, Any]]
"""Record as it was written, and its content."""
_STREAMS = ("console/session", "console/finding", "console/felt")


@dataclass(frozen=True, slots=True)
class Unfinished:
    """An examination that an earlier run began and did not end.

    Attributes:
        files: its recordings, oldest first.
        records: stream and record of its begin, its findings and its samples of the map, in the order of their writing.
            Their times do not give it: the site's clock may have begun again.
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
    # A journal that changes its file writes the last records again: the first place of each counts.
    entries: dict[Written, tuple[dict[str, Any], Path]] = {}
    for file, (made, found) in contents.items():
        for written, record in found if made == newest else ():
            entries.setdefault(written, (record, file))
    examined = [(stream, record, file) for (_, stream, _), (record, file) in entries.items()]
    sessions = [place for place, (stream, _, _) in enumerate(examined) if stream == "console/session"]
    if not sessions or examined[sessions[-1]][1].get("what") != "begin":
        return Unfinished()
    since = examined[sessions[-1] :]
    same = bool(now) and newest == now
    return Unfinished(
        tuple(dict.fromkeys(file for _, _, file in since)),
        tuple((stream, record) for stream, record, _ in since),
        "" if same else str(since[0][1].get("pseudonym")),
    )


def _read(path: Path) -> tuple[str, list[Entry]]:
    """Return the boot identifier of a file and its entries of examinations; a truncated file yields what is left."""
    made = ""
    entries: list[Entry] = []
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
                    written = record.log_time, topics[record.channel_id], record.data
                    yield written, dict(msgpack.unpackb(record.data))
