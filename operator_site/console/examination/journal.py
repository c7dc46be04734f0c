"""What people did and found at the console, on the disk: nothing is called saved before the disk has it.

A recording that failed is begun again in another file, with all that was not saved: a disk may have room again.
A console that starts while an examination is under way, for another one crashed or was ended, goes on with it.
"""

import errno
import logging
import math
from collections import Counter
from pathlib import Path
from typing import Any

import msgpack

from common.files.unique_path import free_name
from common.recording.recorder import Recorder
from operator_site.console.examination.resume import KeptBefore, boot, kept_before

log = logging.getLogger(__name__)

SCHEMAS: dict[str, dict[str, object]] = {
    "console/finding": {
        "type": "object",
        "description": "id, at_s, kind, finger, x_m, y_m (m of the remote bench), text, compare, note; a later "
        "record of the same id replaces an earlier one",
    },
    "console/act": {
        "type": "object",
        "description": "at_s, who, verb, details, ok, answer: who asked for what. The record before an act has ok "
        "null; one with the same at_s, who and verb replaces it when it was answered",
    },
    "console/alarm": {"type": "object", "description": "an alarm as it began, rose or ended"},
    "console/felt": {
        "type": "object",
        "description": "samples: quantity, key, touch, finger, x_m, y_m, t_s, value, variance, name of each that the "
        "map took since the record before; a console that goes on with the examination shows them again",
    },
    "console/session": {"type": "object", "description": "what (begin, end), at_s, pseudonym, wall_clock, who, sides"},
}
AGAIN_S = 5.0
"""A recording that failed is tried again so often."""
_MOST_UNSAVED = 20_000
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT)


class Journal:
    """Writes to `PATH`, or where that exists, and after failures, to `PATH` with -1, -2 ... in its name.

    What an earlier run or one that was killed has kept is never written over. Time is an argument, s.

    Attributes:
        before: the examination that an earlier run has left under way.
        files: those that hold what this examination found.
    """

    def __init__(self, path: Path | None, metadata: dict[str, str]):
        """Open the recording; without a path nothing is ever saved. A full disk is tried again.

        Raises:
            OSError: it cannot be created.
        """
        self._path, self._metadata = path, {"boot": boot(), **metadata}
        self.before = KeptBefore() if path is None else kept_before(path, self._metadata["boot"])
        self.files: list[Path] = [] if self.before.cut_off else [*self.before.files]
        self._saved_findings: set[int | None] = set() if self.before.cut_off else {*self.before.findings}
        self._unsaved: list[tuple[str, int, bytes, int | None]] = []
        """Stream, time and payload of what is not saved yet, and the finding that it is."""
        self._confirmed: Counter[str] = Counter()
        self._tried_s = -math.inf
        self._recorder: Recorder | None = None
        if path is not None:
            try:
                self._open(path)
            except OSError as error:
                if error.errno not in _NO_ROOM:
                    raise
                log.warning("%s: %s", path, error.strerror)

    @property
    def failed(self) -> bool:
        """Whether what is given now stays in memory."""
        return self._recorder is None or self._recorder.failed is not None

    @property
    def enabled(self) -> bool:
        """Whether there is a file to save to at all."""
        return self._path is not None

    @property
    def unsaved(self) -> int:
        """Records that are not on the disk."""
        return len(self._unsaved)

    def is_saved(self, finding: int) -> bool:
        """Whether the newest record of a finding is on the disk."""
        return finding in self._saved_findings

    def write(self, stream: str, now_s: float, record: dict[str, Any]) -> None:
        """Keep one record of a stream of SCHEMAS; with a finding's it is unsaved again until this one is saved."""
        finding = record["id"] if stream == "console/finding" else None
        if finding is not None:
            self._saved_findings.discard(finding)
        kept = stream, round(max(0.0, now_s) * 1e9), msgpack.packb(record), finding
        self._unsaved.append(kept)
        if len(self._unsaved) > _MOST_UNSAVED:  # acts and alarms go before findings do
            lesser = next((n for n, entry in enumerate(self._unsaved) if entry[3] is None), 0)
            del self._unsaved[lesser]
        self._hand(kept)

    def forget(self) -> None:
        """Another examination begins: its findings are counted anew."""
        self._saved_findings.clear()
        del self.files[:-1]

    def step(self, now_s: float) -> None:
        """Take account of what was written; try again what failed."""
        recorder = self._recorder
        if recorder is not None and recorder.failed is None:
            left = []
            for kept in self._unsaved:
                stream = kept[0]
                if recorder.written[stream] > self._confirmed[stream]:
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
        """Write what is queued and close the file."""
        if self._recorder is not None:
            self._recorder.close()

    def _hand(self, kept: tuple[str, int, bytes, int | None]) -> None:
        if self._recorder is not None and self._recorder.failed is None:
            self._recorder.write(*kept[:3])

    def _begin_again(self, path: Path) -> None:
        if self._recorder is not None:
            self._recorder.close()
            if not self._recorder.written:  # nothing of it is lost, and a disk that stays full is not strewn with files
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
        self._recorder = Recorder(free, SCHEMAS, self._metadata, durable=True)
        self._confirmed = Counter()
        self.files.append(free)
