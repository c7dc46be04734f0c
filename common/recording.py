"""Recording to MCAP: small chunks by source time, written by a thread of its own.

A full disk, a slow disk or a crash of the writer never reaches the loop: `write` only puts into a
bounded queue and counts what did not fit.
"""

import contextlib
import json
import logging
import queue
import threading
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from mcap.writer import CompressionType, Writer

log = logging.getLogger(__name__)

CHUNK_BYTES = 16 * 1024
FLUSH_S = 0.25
_QUEUE_LENGTH = 20_000
PACKET_SCHEMA: dict[str, object] = {
    "type": "array",
    "description": "a packet of the link as it stands on the wire, see docs/protocols.md",
}


class Recorder:
    """Writes streams to one MCAP file.

    Each payload is MessagePack; the channel's schema (JSON schema text) names its fields.
    """

    def __init__(self, path: Path, schemas: Mapping[str, Mapping[str, object]], metadata: Mapping[str, str]):
        """Open `path` and start the writing thread.

        Args:
            path: file to create; its folder must exist.
            schemas: for each stream that will be written, its JSON schema.
            metadata: facts about the recording (configuration, key fingerprints, calibration), kept in the file.

        Raises:
            OSError: the file cannot be created.
        """
        self.written: Counter[str] = Counter()
        self.lost = 0
        self.failed: str | None = None
        self._queue: queue.SimpleQueue[tuple[str, int, bytes] | None] = queue.SimpleQueue()
        self._file = path.open("wb")
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES, compression=CompressionType.NONE)
        self._writer.start(profile="teletaction", library="teletaction")
        self._writer.add_metadata("session", dict(metadata))
        self._channels: dict[str, int] = {}
        for stream, schema in schemas.items():
            schema_id = self._writer.register_schema(stream, "jsonschema", json.dumps(schema).encode())
            self._channels[stream] = self._writer.register_channel(stream, "msgpack", schema_id)
        self._thread = threading.Thread(target=self._drain, name="recorder", daemon=True)
        self._thread.start()

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Queue one message with its source time (ns, monotonic). Never blocks; a full queue loses it, counted."""
        if self.failed is not None or self._queue.qsize() >= _QUEUE_LENGTH:
            self.lost += 1
            return
        self._queue.put((stream, time_ns, payload))

    def close(self) -> None:
        """Write what is queued, close the file with its index, end the thread."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join(timeout=5.0)

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _drain(self) -> None:
        try:
            while self._write_queued():
                # One wake-up per flush keeps this thread off the interpreter while the loop runs.
                time.sleep(FLUSH_S)
            self._writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
            self._file.close()
        except OSError as error:
            self.failed = str(error)
            with contextlib.suppress(OSError):  # what it still holds cannot be written either
                self._file.close()
            log.error("recording stopped: %s", error)

    def _write_queued(self) -> bool:
        """Write all that is queued; False once the closing mark was met."""
        for _ in range(self._queue.qsize()):
            item = self._queue.get()
            if item is None:
                return False
            stream, time_ns, payload = item
            self._writer.add_message(self._channels[stream], time_ns, payload, time_ns)
            self.written[stream] += 1
        self._file.flush()
        return True
