"""The process that writes a recording: MCAP from what its owner hands over, until the owner ends it, or is gone.

Apart from the loop that it records, for both would want one interpreter: ticks beside a writing thread came more than a
millisecond late, four times a second. Its standard output is the file, its standard input a stream socket on which both
sides speak MessagePack: the recording's head, an object with `metadata`, `schemas`, `attachments` and `durable`; then
lists of [stream's number, ns, payload]; null at the end. Back come [messages written of each stream so far, why it
failed or null, whether the disk is full, whether this is the last].
"""

import errno
import os
import select
import socket
import time
from contextlib import suppress
from typing import IO

import msgpack
from mcap.writer import CompressionType, Writer

CHUNK_BYTES = 256 * 1024
"""More than is written between two flushes: the library keeps an index entry in memory for each chunk of the file."""
FLUSH_S = 0.25
"""Between two ends of a chunk: half of what may be lost, the other half is for a busy machine."""
_TAKEN_BYTES = 1 << 18
"""At most at once."""


class RecordingWriter:
    """Takes what was handed over, and writes it. Ends chunks when it is told to.

    Attributes:
        written: messages of each stream that were handed to the system; with `durable`, that are on the disk.
        ended: whether the closing mark has come.
    """

    def __init__(self, file: IO[bytes]) -> None:
        """Write to a file that is empty."""
        self.written: list[int] = []
        self.ended = False
        self._file = file
        self._writer = Writer(file, chunk_size=CHUNK_BYTES, compression=CompressionType.NONE, enable_data_crcs=True)
        self._unpacker = msgpack.Unpacker(max_buffer_size=0)
        self._added: list[int] = []
        self._channels: list[int] = []
        self._durable = False

    def take(self, handed: bytes) -> None:
        """Add what is in the next bytes of the stream."""
        self._unpacker.feed(handed)
        for item in self._unpacker:
            if isinstance(item, dict):
                self._begin(**item)
            elif item is None:
                self.ended = True
            else:
                for stream, time_ns, payload in item:
                    self._writer.add_message(self._channels[stream], time_ns, payload, time_ns)
                    self._added[stream] += 1
        if self._durable:
            self.flush()

    def flush(self) -> None:
        """End the chunk and hand it to the system, and to the disk if it is a durable recording."""
        if self._added != self.written:
            self._writer.flush()  # type: ignore[no-untyped-call]  # the library leaves it untyped
            self._sync()
            self.written = self._added.copy()

    def finish(self) -> None:
        """End the file with its index."""
        self.flush()
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._file.flush()
        self._sync()

    def _begin(
        self, metadata: dict[str, str], schemas: dict[str, bytes], attachments: dict[str, bytes], durable: bool
    ) -> None:
        self._durable = durable
        self._writer.start(profile="teletaction", library="teletaction")
        self._writer.add_metadata("session", metadata)
        for name, content in attachments.items():
            self._writer.add_attachment(0, 0, name, "application/octet-stream", content)
        for stream, schema in schemas.items():
            number = self._writer.register_schema(stream, "jsonschema", schema)
            self._channels.append(self._writer.register_channel(stream, "msgpack", number))
        self._added = [0] * len(schemas)
        self.flush()

    def _sync(self) -> None:
        if self._durable:
            os.fsync(self._file.fileno())


def write_recording(owner: socket.socket, file: IO[bytes]) -> None:
    """Write what comes from the owner until the closing mark, or the owner's end, or a failure, which it is told."""
    writer = RecordingWriter(file)
    try:
        _write(owner, writer)
        writer.finish()
        why, full = None, False
    except Exception as error:  # whatever it is, it ends the recording, and the owner must know
        why = str(error) or type(error).__name__
        full = isinstance(error, OSError) and error.errno == errno.ENOSPC
    with suppress(OSError):  # of an owner that is gone
        owner.sendall(_told(writer, why, full=full, last=True))


def _write(owner: socket.socket, writer: RecordingWriter) -> None:
    due_s = time.monotonic() + FLUSH_S
    told = writer.written
    while not writer.ended:
        ready, _, _ = select.select([owner], [], [], max(0.0, due_s - time.monotonic()))
        if ready:
            handed = b""
            with suppress(ConnectionError):  # so ends an owner that has not listened to all that it was told
                handed = owner.recv(_TAKEN_BYTES)
            if not handed:
                return
            writer.take(handed)
        if time.monotonic() >= due_s:
            due_s = time.monotonic() + FLUSH_S
            writer.flush()
        if writer.written != told:
            with suppress(BlockingIOError, ConnectionError):  # who does not listen is told more the next time
                owner.send(_told(writer), socket.MSG_DONTWAIT)
                told = writer.written


def _told(writer: RecordingWriter, why: str | None = None, *, full: bool = False, last: bool = False) -> bytes:
    packed: bytes = msgpack.packb([writer.written, why, full, last])
    return packed


def main() -> None:
    """Be the process."""
    # It never takes the processor from a loop on waking up, and has its share of it like everybody else.
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    file = open(1, "wb", closefd=False)  # noqa: SIM115 - what it cannot write at its end is known by then
    with socket.socket(fileno=os.dup(0)) as owner:
        write_recording(owner, file)
    with suppress(OSError):
        file.close()


if __name__ == "__main__":
    main()
