"""Records to an MCAP file by a separate process: where all processes are killed, at most the last half second is lost.

A loss of power takes the last 5 s and what a slow disk still had to write, except from a durable recording.

A full disk, a slow disk or a crash of the writer never reaches the loop: `write` only appends to a bounded queue and
counts messages that do not fit. A failed recording stays stopped, even if the disk has room again. Its file is intact
up to the failure, and `teletaction recover` makes a whole one from it.
"""

import json
import logging
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections import Counter, deque
from collections.abc import Mapping
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import IO

import msgpack

from common.files.private_file import create_private
from common.files.unique_path import set_aside
from common.recording.clock_anchor import ClockAnchor
from common.version import software_version

log = logging.getLogger(__name__)

_HAND_NS = 33_000_000
"""Minimum interval between two transfers of the queue to the writer, ns; a durable recording has none."""
_BATCH = 256
"""Maximum number of messages in one transfer."""
_QUEUE_LENGTH = 20_000
"""Maximum number of queued messages."""
_CLOSE_S = 5.0
"""Maximum time for closing a recording, s."""
_REPORT_BYTES = 1 << 16
"""Maximum number of bytes that are read at once from the writer."""
_OWNERS_ENDS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals that end all processes of a service or terminal; the writer blocks them, because it ends after its owner."""
PACKET_SCHEMA: dict[str, object] = {
    "type": "array",
    "description": "a packet of the link as it stands on the wire, see docs/protocols.md",
}


class Recorder:
    """Writes streams to one MCAP file.

    Each payload is MessagePack; the channel's schema (JSON schema text) names its fields.
    """

    def __init__(
        self,
        path: Path,
        schemas: Mapping[str, Mapping[str, object]],
        metadata: Mapping[str, str],
        attachments: Mapping[str, bytes] | None = None,
        *,
        durable: bool = False,
        encrypt_for: str | None = None,
    ):
        """Create `path` and start the writing process.

        Args:
            path: file to create, with mode 0600; its folder must exist. An earlier file there is renamed to -1, -2 ...
            schemas: JSON schema of each stream.
            metadata: facts about the recording (configuration, own key's fingerprint, hashes of tables), no secret;
                the program's version and a clock anchor are added.
            attachments: whole files by name, such as calibrated tables, so that a replay needs nothing else.
            durable: write each message to the disk at once, so that it outlasts a loss of power; only such messages
                count as written. For a few records that must not be lost.
            encrypt_for: Z85 public key for whose owner the file is encrypted; by default it is plain.

        Raises:
            ValueError: the file is to be encrypted, and the extra `privacy` is not installed.
            OSError: the file cannot be created, an earlier one cannot be renamed, or `path` is a symbolic link.
        """
        self._failed: str | None = None
        self.failed_ns: int | None = None
        """Time at which the recording stopped, ns of the machine's monotonic clock; None while it runs."""
        self.disk_full = False
        """Whether the recording stopped because the disk is full."""
        self._written: Counter[str] = Counter()
        self._refused = 0
        self._slow_logged = False
        self._taken = 0
        self._closed = False
        self._mark_left = False
        """Whether the closing mark has been packed for the writer."""
        self._ended = False
        """Whether the writer has sent its last report."""
        self._durable = durable
        self._streams = {stream: number for number, stream in enumerate(schemas)}
        self._waiting: deque[tuple[int, int, bytes]] = deque()
        self._handed_ns = 0
        self._leaving = memoryview(
            msgpack.packb(
                {
                    "metadata": {"version": software_version(), **ClockAnchor.now().metadata(), **metadata},
                    "schemas": {stream: json.dumps(schema).encode() for stream, schema in schemas.items()},
                    "attachments": dict(attachments or {}),
                    "durable": durable,
                    "encrypt_for": encrypt_for,
                }
            )
        )
        """Rest of the bytes of the transfer in progress."""
        if encrypt_for is not None and find_spec("nacl") is None:
            raise ValueError(f"{path}: an encrypted recording needs `pip install teletaction[privacy]`")
        self._reports = msgpack.Unpacker()
        set_aside(path)
        with create_private(path) as file:
            self._writer, self._process = _start_writer(file)
        if durable:
            _sync_folder(path.parent)
        self._exchange()

    @property
    def written(self) -> Counter[str]:
        """Number of messages of each stream that the system has taken; with `durable`, that are on the disk."""
        self._exchange()
        return self._written

    @property
    def failed(self) -> str | None:
        """Reason why the recording stopped; None while it runs."""
        self._exchange()
        return self._failed

    @property
    def lost(self) -> int:
        """Number of messages that did not fit into the queue or came to a stopped recording."""
        abandoned = 0 if self._failed is None else self._taken - self._written.total()
        return self._refused + abandoned

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Queue one message with its source time (ns, monotonic). Never blocks; with a full queue it counts as lost.

        Raises:
            ValueError: the recording has no such stream.
        """
        number = self._streams.get(stream)
        if number is None:
            raise ValueError(f"stream {stream!r} is not in the recording's schemas: {', '.join(self._streams)}")
        if self._ended or self._closed or len(self._waiting) >= _QUEUE_LENGTH:
            self._refused += 1
        else:
            self._taken += 1
            self._waiting.append((number, time_ns, payload))
        if self._durable or not 0 <= time_ns - self._handed_ns < _HAND_NS:
            self._handed_ns = time_ns
            self._exchange()

    def close(self) -> None:
        """Write the queue, close the file with its index, and end the process."""
        if self._closed:
            return
        self._closed = True
        end_s = time.monotonic() + _CLOSE_S
        self._exchange()
        while not self._ended and (left_s := end_s - time.monotonic()) > 0.0:
            ready = select.poll()
            ready.register(self._writer, select.POLLIN | (select.POLLOUT if self._leaving else 0))
            ready.poll(left_s * 1e3)
            self._exchange()
        self._writer.close()
        if self._ended:
            self._process.wait()
        else:  # the writer still writes the messages that it has, once the disk responds again
            self._fail(f"the disk accepted no data for {_CLOSE_S:g} s")

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _exchange(self) -> None:
        """Transfer the queue as far as the writer takes it, and read the writer's reports; never waits."""
        if self._ended:
            return
        with suppress(BlockingIOError, ConnectionError):  # a writer that is gone has reported the reason
            while self._leaving or self._pack():
                self._leaving = self._leaving[self._writer.send(self._leaving) :]
        with suppress(BlockingIOError):
            while not self._ended:
                self._listen()
        if self._refused and not self._slow_logged:
            self._slow_logged = True
            log.warning("recording: the disk is slower than the data, %d messages lost so far", self._refused)

    def _pack(self) -> bool:
        """Pack the next transfer; return False if there is none."""
        batch = [self._waiting.popleft() for _ in range(min(len(self._waiting), _BATCH))]
        if not batch and (self._mark_left or not self._closed):
            return False
        self._mark_left = not batch
        self._leaving = memoryview(msgpack.packb(batch or None))
        return True

    def _listen(self) -> None:
        received = b""
        with suppress(ConnectionError):
            received = self._writer.recv(_REPORT_BYTES)
        if not received:
            self._fail("the process that writes it has ended")
        self._reports.feed(received)
        for written, why, full, last in self._reports:
            self._written = Counter(
                {stream: count for stream, count in zip(self._streams, written, strict=False) if count}
            )
            self._ended = last
            if why is not None:
                self._fail(why, disk_full=full)

    def _fail(self, why: str, *, disk_full: bool = False) -> None:
        self._ended = True
        self._waiting.clear()
        if self._failed is None:
            self._failed, self.failed_ns, self.disk_full = why, time.monotonic_ns(), disk_full
            log.error("recording stopped: %s", why)


def _start_writer(file: IO[bytes]) -> tuple[socket.socket, "subprocess.Popen[bytes]"]:
    """Start the process that writes to a file; return this end of the socket to it, and the process."""
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    # -P: Python does not import a folder `common` of the working directory.
    command = [sys.executable, "-P", "-m", "common.recording.writer_process"]
    with theirs:
        before = signal.pthread_sigmask(signal.SIG_BLOCK, _OWNERS_ENDS)  # the process inherits the mask
        try:
            return ours, subprocess.Popen(command, stdin=theirs.fileno(), stdout=file)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _sync_folder(folder: Path) -> None:
    """Wait until a folder's list of files is on the disk: without it a new file is lost with the power."""
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def recording_figures(recorder: Recorder | None) -> dict[str, object]:
    """Return the figures of a site's recording for its status file; None stands for a site that does not record."""
    return {
        "recorded": {} if recorder is None else dict(recorder.written),
        "recording_lost": 0 if recorder is None else recorder.lost,
        "recording_failed": "" if recorder is None else recorder.failed or "",
        "disk_full": recorder is not None and recorder.disk_full,
        "recording_failed_ns": None if recorder is None else recorder.failed_ns,
    }
