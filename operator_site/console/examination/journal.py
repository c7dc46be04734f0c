"""Records actions and findings on the disk, and confirms each one only once the disk has it.

After a failure the journal opens a new file and writes all unsaved records to it, because a full disk may have room
again. A console that restarts during an examination continues that examination.
"""

import logging
import math
from collections import Counter
from pathlib import Path
from typing import Any

import msgpack

from common.files.no_room import NO_ROOM
from common.files.unique_path import free_name
from common.recording.clock_anchor import boot_id
from common.recording.recorder import Recorder
from operator_site.console.examination.resume import Unfinished, unfinished

log = logging.getLogger(__name__)

_DESCRIBED = {
    "console/finding": "id, at_s, kind, finger, x_m, y_m (m of the remote bench), text, compare, note, contrast "
    "(quantity, value, sd, clear: K or a ratio), confidence, body (region, side, landmark, landmark_mm), withdrawn "
    "(the reason), change (mark, note, edit, withdraw, undo); a later record of the same id replaces an earlier "
    "one. Records before change have none of the fields from contrast on",
    "console/act": "at_s, who, verb, details, ok, answer: who asked for what. The record before an act has ok "
    "null; one with the same at_s, who and verb replaces it when it was answered",
    "console/alarm": "an alarm as it began, rose or ended",
    "console/felt": "samples: quantity, key, touch, finger, x_m, y_m, t_s, value, variance, name of each that the "
    "map took since the record before; a console that continues the examination shows them again",
    "console/camera": "sequence, captured_s (operator site's clock), uncertainty_s, is_key, width, height, content "
    "(VP8, RFC 6386): a picture of the camera as the console relayed it",
    "console/voice": "direction (from_remote, to_remote), sequence, captured_s (operator site's clock), "
    "uncertainty_s, content (one frame of Opus, RFC 6716: 48 kHz, one channel, 20 ms): a sound as the console "
    "relayed it",
    "console/session": "what (begin, end), at_s, pseudonym, wall_clock, who, sides, body (region, side, landmark, "
    "landmark_mm), consented (what the patient has confirmed at the begin to have recorded)",
}
SCHEMAS: dict[str, dict[str, object]] = {
    stream: {"type": "object", "description": text} for stream, text in _DESCRIBED.items()
}
"""JSON schema of each stream of the console."""
AGAIN_S = 5.0
"""Interval between two attempts to reopen a failed recording, s."""
_MOST_UNSAVED = 15_000
"""Maximum number of unsaved records in memory."""
_MEDIA = ("console/camera", "console/voice")
_MOST_MEDIA = 4_000
"""Maximum number of pictures and sounds that wait for the disk.

With the unsaved records they fit into the recorder's queue, which would refuse a finding when it is full.
"""


class Journal:
    """Writes to `PATH`; if that exists, after failures, and for each further examination to `PATH` with -1, -2 ...

    Files of an earlier run are never overwritten. Time is an argument, s.

    Attributes:
        unfinished: the unfinished examination of an earlier run.
        files: the files that hold the records of this examination.
    """

    def __init__(self, path: Path | None, metadata: dict[str, str], encrypt_for: str | None = None):
        """Open the recording. A full disk is tried again later.

        Args:
            path: the file; without one nothing is saved.
            metadata: facts about the recording.
            encrypt_for: public key for whose owner the files are encrypted; by default they are plain.

        Raises:
            OSError: the recording cannot be created, for another reason than a full disk.
        """
        self._encrypt_for = encrypt_for
        self._path, self._metadata = path, {"boot": boot_id(), **metadata}
        self.unfinished = Unfinished() if path is None else unfinished(path, self._metadata["boot"])
        self.files: list[Path] = [] if self.unfinished.cut_off else [*self.unfinished.files]
        self._saved_findings: set[int | None] = set() if self.unfinished.cut_off else {*self.unfinished.findings}
        self._unsaved: list[tuple[str, int, bytes, int | None]] = []
        """Stream, time in ns and payload of each unsaved record, and the number of its finding or None."""
        self._confirmed: Counter[str] = Counter()
        self._media = 0
        """Number of pictures and sounds that the recorder has taken."""
        self._tried_s = -math.inf
        self._examined = False
        """Whether the recorder has records of an examination."""
        self._recorder: Recorder | None = None
        if path is not None:
            try:
                self._open(path)
            except OSError as error:
                if error.errno not in NO_ROOM:
                    raise
                log.warning("%s: %s", path, error.strerror)

    @property
    def failed(self) -> bool:
        """Whether new records stay in memory because the recording has failed or is not open."""
        return self._recorder is None or self._recorder.failed is not None

    @property
    def enabled(self) -> bool:
        """Whether a recording is configured."""
        return self._path is not None

    @property
    def unsaved(self) -> int:
        """Number of records that are not on the disk."""
        return len(self._unsaved)

    def is_saved(self, finding: int) -> bool:
        """Return whether the newest record of a finding is on the disk."""
        return finding in self._saved_findings

    def write(self, stream: str, now_s: float, record: dict[str, Any]) -> None:
        """Write one record of a stream of SCHEMAS; its finding counts as unsaved until the disk has this record."""
        finding = record["id"] if stream == "console/finding" else None
        if finding is not None:
            self._saved_findings.discard(finding)
        kept = stream, round(max(0.0, now_s) * 1e9), msgpack.packb(record), finding
        self._unsaved.append(kept)
        if len(self._unsaved) > _MOST_UNSAVED:  # acts and alarms are dropped before findings
            lesser = next((n for n, entry in enumerate(self._unsaved) if entry[3] is None), 0)
            dropped, *_ = self._unsaved.pop(lesser)
            self._confirmed[dropped] += 1  # the recorder counts it, too, which must not confirm the next one
        self._hand(kept)

    def write_media(self, stream: str, now_s: float, record: dict[str, Any]) -> None:
        """Write one picture or sound; it is lost while the recording has failed, or while _MOST_MEDIA wait."""
        recorder = self._recorder
        if recorder is not None and self._media - sum(recorder.written[each] for each in _MEDIA) < _MOST_MEDIA:
            self._media += 1
            self._hand((stream, round(max(0.0, now_s) * 1e9), msgpack.packb(record), None))

    def forget(self) -> None:
        """Forget the saved findings and earlier files, because another examination begins.

        It gets a file of its own: the report of the examination before may be written later, and would find it.
        """
        self._saved_findings.clear()
        if self._examined and self._path is not None:
            self._begin_again(self._path)
        self.files = [] if self._recorder is None else self.files[-1:]

    def step(self, now_s: float) -> None:
        """Confirm the written records; retry a failed recording."""
        recorder = self._recorder
        if recorder is not None and recorder.failed is None:
            left = []
            # Read once: the recorder counts on while this loop runs.
            written = {stream: recorder.written[stream] for stream in SCHEMAS}
            for kept in self._unsaved:
                stream = kept[0]
                if written[stream] > self._confirmed[stream]:
                    self._confirmed[stream] += 1
                else:
                    left.append(kept)
            waiting = {kept[3] for kept in left}
            self._saved_findings |= {kept[3] for kept in self._unsaved if kept[3] is not None} - waiting
            self._unsaved = left
        elif self._path is not None and not 0.0 <= now_s - self._tried_s < AGAIN_S:
            self._tried_s = now_s
            self._begin_again(self._path)

    def close(self) -> None:
        """Write the queued records and close the file."""
        if self._recorder is not None:
            self._recorder.close()

    def _hand(self, kept: tuple[str, int, bytes, int | None]) -> None:
        if self._recorder is not None and self._recorder.failed is None:
            self._examined = self._examined or kept[0] in ("console/session", "console/finding")
            self._recorder.write(*kept[:3])

    def _begin_again(self, path: Path) -> None:
        if self._recorder is not None:
            self._recorder.close()
            if not self._recorder.written:  # an empty file: each attempt on a full disk would leave one
                self.files.pop().unlink(missing_ok=True)
            self._recorder = None
        try:
            self._open(path)
        except OSError as error:
            log.warning("%s: %s", path, error.strerror)
            return
        for kept in self._unsaved:
            self._hand(kept)

    def _open(self, path: Path) -> None:
        free = free_name(path)
        self._recorder = Recorder(free, SCHEMAS, self._metadata, durable=True, encrypt_for=self._encrypt_for)
        self._confirmed, self._media, self._examined = Counter(), 0, False
        self.files = [*self.files, free]  # a report that is being written keeps its own list
