"""Writes a recording as MCAP in a process of its own, until its owner closes the recording or is gone.

It is a process and no thread, because a thread would share the interpreter with the loop: ticks beside a writing thread
came more than a millisecond late, four times a second.

Its standard output is the file. Its standard input is a stream socket with MessagePack in both directions. The owner
sends the recording's head, an object with `metadata`, `schemas`, `attachments`, `durable` and `encrypt_for`; then lists
of [number of the stream, ns, payload]; null at the end. The process sends reports: [number of messages written of each
stream, reason of a failure or null, whether the disk is full, whether this report is the last].
"""

import errno
import os
import select
import socket
import threading
import time
from contextlib import suppress
from io import BufferedIOBase
from typing import IO

import msgpack
from mcap.writer import CompressionType, Writer

from common.files.no_room import NO_ROOM

CHUNK_BYTES = 256 * 1024
"""Maximum size of a chunk, bytes: more than one flush interval contains, because the library keeps an index entry in
memory for each chunk of the file."""
FLUSH_S = 0.25
"""Interval between two ends of a chunk, s: half of the time that may be lost; the rest is for a busy machine."""
SYNC_S = 5.0
"""Interval between two waits for the disk, s; a loss of power takes no more than this, and the time of the wait."""
_NOT_A_FILE = (errno.EINVAL, errno.ENOTSUP)
"""Numbers of the errors of a device, which has nothing to wait for."""
_TAKEN_BYTES = 1 << 18
"""Maximum number of bytes that are read at once from the owner."""


class RecordingWriter:
    """Writes the messages of its owner.

    Attributes:
        written: number of messages of each stream that the system has taken; with `durable`, that are on the disk.
        ended: whether the closing mark has come.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self.written: list[int] = []
        self.ended = False
        self._file, self._end = file, file.flush
        self._writer = _mcap(file)
        self._unpacker = msgpack.Unpacker(max_buffer_size=0)
        self._added: list[int] = []
        self._channels: list[int] = []
        self._durable = False
        self._closing = threading.Event()
        self._disk_error: OSError | None = None

    def take(self, received: bytes) -> None:
        """Take the next bytes of the owner's stream."""
        self._unpacker.feed(received)
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
        """End the chunk and give it to the system; in a durable recording, wait until it is on the disk.

        Raises:
            OSError: the system or the disk did not take it, or something before it.
        """
        if self._disk_error is not None:
            raise self._disk_error
        if self._added != self.written:
            self._writer.flush()  # type: ignore[no-untyped-call]  # the library leaves it untyped
            self._sync()
            self.written = self._added.copy()

    def finish(self) -> None:
        """End the file with its index, and wait until it is on the disk."""
        self.flush()
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._end()
        self._sync()
        _wait_for_disk(self._file.fileno())

    def close(self) -> None:
        """End the thread that waits for the disk."""
        self._closing.set()

    def _begin(
        self,
        metadata: dict[str, str],
        schemas: dict[str, bytes],
        attachments: dict[str, bytes],
        durable: bool,
        encrypt_for: str | None = None,
    ) -> None:
        self._durable = durable
        if encrypt_for is not None:
            self._encrypt(encrypt_for)
        self._writer.start(profile="teletaction", library="teletaction")
        self._writer.add_metadata("session", metadata)
        for name, content in attachments.items():
            self._writer.add_attachment(0, 0, name, "application/octet-stream", content)
        for stream, schema in schemas.items():
            number = self._writer.register_schema(stream, "jsonschema", schema)
            self._channels.append(self._writer.register_channel(stream, "msgpack", number))
        self._added = [0] * len(schemas)
        self.flush()
        if not durable:
            threading.Thread(target=self._keep_on_disk, args=(self._file.fileno(),), daemon=True).start()

    def _encrypt(self, public_key: str) -> None:
        from common.recording.encrypted_file import EncryptedWriter, Header  # noqa: PLC0415 - few recordings need it

        encrypted = EncryptedWriter(self._file, *Header.make(public_key))
        self._end = encrypted.end
        self._writer = _mcap(encrypted)

    def _sync(self) -> None:
        if self._durable:
            os.fsync(self._file.fileno())

    def _keep_on_disk(self, number: int) -> None:
        """Wait for the disk every SYNC_S, beside the thread that writes: a slow disk holds up no messages."""
        while not self._closing.wait(SYNC_S):
            try:
                _wait_for_disk(number)
            except OSError as error:
                self._disk_error = error
                return


def _wait_for_disk(number: int) -> None:
    """Wait until the disk has the data of a file."""
    try:
        os.fdatasync(number)
    except OSError as error:
        if error.errno not in _NOT_A_FILE:
            raise


def _mcap(file: "IO[bytes] | BufferedIOBase") -> Writer:
    return Writer(file, chunk_size=CHUNK_BYTES, compression=CompressionType.NONE, enable_data_crcs=True)  # type: ignore[arg-type]  # it takes any stream


def write_recording(owner: socket.socket, file: IO[bytes]) -> None:
    """Write the owner's messages until the closing mark, the owner's end or a failure, and report the result to it."""
    writer = RecordingWriter(file)
    try:
        _write(owner, writer)
        writer.finish()
        why, full = None, False
    except Exception as error:  # any error ends the recording, and the owner must get the reason
        why = str(error) or type(error).__name__
        full = isinstance(error, OSError) and error.errno in NO_ROOM
    finally:
        writer.close()
    with suppress(OSError):  # the owner may be gone
        owner.sendall(_report(writer, why, full=full, last=True))


def _write(owner: socket.socket, writer: RecordingWriter) -> None:
    due_s = time.monotonic() + FLUSH_S
    reported = writer.written
    while not writer.ended:
        ready, _, _ = select.select([owner], [], [], max(0.0, due_s - time.monotonic()))
        if ready:
            received = b""
            with suppress(ConnectionError):  # raised for an owner that ended with unread reports
                received = owner.recv(_TAKEN_BYTES)
            if not received:
                return
            writer.take(received)
        if time.monotonic() >= due_s:
            due_s = time.monotonic() + FLUSH_S
            writer.flush()
        if writer.written != reported:
            with suppress(BlockingIOError, ConnectionError):  # a later report contains these numbers, too
                owner.send(_report(writer), socket.MSG_DONTWAIT)
                reported = writer.written


def _report(writer: RecordingWriter, why: str | None = None, *, full: bool = False, last: bool = False) -> bytes:
    packed: bytes = msgpack.packb([writer.written, why, full, last])
    return packed


def main() -> None:
    """Run the process."""
    # With this policy it never preempts a loop on waking up, but has its usual share of the processor.
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    file = open(1, "wb", closefd=False)  # noqa: SIM115 - an error on closing has been reported by then
    with socket.socket(fileno=os.dup(0)) as owner:
        write_recording(owner, file)
    with suppress(OSError):
        file.close()


if __name__ == "__main__":
    main()
