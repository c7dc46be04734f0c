"""Recording to MCAP by a thread of its own: at most the last half second is lost when the process is killed.

A full disk, a slow disk or a crash of the writer never reaches the loop: `write` only puts into a bounded queue and
counts what did not fit. A recording that failed stays stopped, even if the disk has room again; the file is good up to
there, and `teletaction recover` makes a whole one of it.
"""

import contextlib
import json
import logging
import os
import queue
import threading
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from mcap.writer import CompressionType, Writer

from common.earlier_file import set_aside
from common.software_version import software_version

log = logging.getLogger(__name__)

CHUNK_BYTES = 256 * 1024
"""More than is written between two flushes: the library keeps an index entry in memory for each chunk of the file."""
FLUSH_S = 0.25
"""Between two ends of a chunk: half of what may be lost, the other half is for a busy machine."""
_QUEUE_LENGTH = 20_000
_CLOSE_S = 5.0
PACKET_SCHEMA: dict[str, object] = {
    "type": "array",
    "description": "a packet of the link as it stands on the wire, see docs/protocols.md",
}
SESSION_SCHEMA: dict[str, object] = {
    "type": "array",
    "description": "[what, session, text]: what became known while recording, as the session's number (0 for none), "
    "the far side's capabilities, or a fault",
}


class Recorder:
    """Writes streams to one MCAP file.

    Each payload is MessagePack; the channel's schema (JSON schema text) names its fields.

    Attributes:
        written: messages of each stream that were handed to the system; with `durable`, that are on the disk.
        failed: why the recording stopped; None while it has not.
    """

    def __init__(
        self,
        path: Path,
        schemas: Mapping[str, Mapping[str, object]],
        metadata: Mapping[str, str],
        attachments: Mapping[str, bytes] | None = None,
        *,
        durable: bool = False,
    ):
        """Open `path` and start the writing thread.

        Args:
            path: file to create; its folder must exist. What an earlier run recorded there is set aside as -1, -2 ...
            schemas: for each stream that will be written, its JSON schema.
            metadata: facts about the recording (configuration, own key's fingerprint, hashes of tables), no secret;
                the program's version is added.
            attachments: whole files by name, such as calibrated tables, so that a replay needs nothing else.
            durable: what counts as written is on the disk, and outlasts a machine that loses its power; it is written
                at once and not with the next flush. For a few records that must not be lost.

        Raises:
            OSError: the file cannot be created, or an earlier one not set aside.
        """
        self.written: Counter[str] = Counter()
        self.failed: str | None = None
        self._refused = 0
        self._taken = 0
        self._closed = False
        self._durable = durable
        self._due = threading.Event()
        """Something is to be written before the next flush."""
        self._queue: queue.SimpleQueue[tuple[str, int, bytes] | None] = queue.SimpleQueue()
        set_aside(path)
        self._file = path.open("wb")
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES, compression=CompressionType.NONE)
        self._writer.start(profile="teletaction", library="teletaction")
        self._writer.add_metadata("session", {"version": software_version(), **metadata})
        for name, content in (attachments or {}).items():
            self._writer.add_attachment(0, 0, name, "application/octet-stream", content)
        self._channels: dict[str, int] = {}
        for stream, schema in schemas.items():
            schema_id = self._writer.register_schema(stream, "jsonschema", json.dumps(schema).encode())
            self._channels[stream] = self._writer.register_channel(stream, "msgpack", schema_id)
        if durable:
            _sync_folder(path.parent)
        self._thread = threading.Thread(target=self._drain, name="recorder", daemon=True)
        self._thread.start()

    @property
    def lost(self) -> int:
        """Messages that did not fit into the queue or came to a recording that had stopped."""
        abandoned = 0 if self.failed is None else self._taken - self.written.total()
        return self._refused + abandoned

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Queue one message with its source time (ns, monotonic). Never blocks; a full queue loses it, counted.

        Raises:
            ValueError: the recording has no such stream.
        """
        if stream not in self._channels:
            raise ValueError(f"stream {stream!r} is not in the recording's schemas: {', '.join(self._channels)}")
        if self._closed or self.failed is not None or self._queue.qsize() >= _QUEUE_LENGTH:
            self._refused += 1
            return
        self._taken += 1
        self._queue.put((stream, time_ns, payload))
        if self._durable:
            self._due.set()

    def close(self) -> None:
        """Write what is queued, close the file with its index, end the thread."""
        if self._closed:
            return
        self._closed = True
        self._queue.put(None)
        self._due.set()
        self._thread.join(timeout=_CLOSE_S)
        if self._thread.is_alive():
            self._fail(f"the disk took nothing for {_CLOSE_S:g} s")

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _drain(self) -> None:
        slow_said = False
        try:
            while self._write_queued():
                if self._refused and not slow_said:
                    slow_said = True
                    log.warning("recording: the disk is slower than the data, %d messages lost so far", self._refused)
                # One wake-up per flush keeps this thread off the interpreter while the loop runs.
                self._due.wait(FLUSH_S)
                self._due.clear()
            self._writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
            self._sync()
            self._file.close()
        except Exception as error:  # whatever it is, it must end the recording only
            self._fail(str(error) or type(error).__name__)
            with contextlib.suppress(OSError):  # what it still holds cannot be written either
                self._file.close()

    def _write_queued(self) -> bool:
        """Write all that is queued and end the chunk; False once the closing mark was met."""
        written: Counter[str] = Counter()
        going_on = True
        for _ in range(self._queue.qsize()):
            item = self._queue.get()
            if item is None:
                going_on = False
                break
            stream, time_ns, payload = item
            self._writer.add_message(self._channels[stream], time_ns, payload, time_ns)
            written[stream] += 1
        self._writer.flush()  # type: ignore[no-untyped-call]
        if written:
            self._sync()
        self.written.update(written)
        return going_on

    def _sync(self) -> None:
        """Wait until the disk has what the system was handed."""
        if self._durable:
            self._file.flush()
            os.fsync(self._file.fileno())

    def _fail(self, why: str) -> None:
        if self.failed is None:
            self.failed = why
            log.error("recording stopped: %s", why)


def _sync_folder(folder: Path) -> None:
    """Wait until the disk has a folder's list of files, without which a new file of it is lost."""
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def recording_figures(recorder: Recorder | None) -> dict[str, object]:
    """What a site's status tells of its recording; None stands for a site that does not record."""
    return {
        "recorded": {} if recorder is None else dict(recorder.written),
        "recording_lost": 0 if recorder is None else recorder.lost,
        "recording_failed": "" if recorder is None else recorder.failed or "",
    }
