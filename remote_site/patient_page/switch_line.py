"""The serial line of the switch: a TCP port of this machine that the remote site opens as `socket://`."""

import contextlib
import logging
import math
import socket as sockets

from common.buses.serial_messages import DeviceKind, FrameReader, Identity, MessageId, PatientSwitchState, encode_frame

log = logging.getLogger(__name__)

RATE_HZ = 100
"""Reports a second."""
_CHUNK = 4096
_HOST = "127.0.0.1"
_IDENTITY = Identity(DeviceKind.PATIENT_SWITCH, 0, "TABLET", 1, RATE_HZ, 0.0, 1.0)


class SwitchLine:
    """Speaks the protocol of a patient switch with one host at a time. The newest connection replaces an older one."""

    def __init__(self, port: int) -> None:
        """Listen on loopback at `port`; raises OSError where the port is in use."""
        try:
            self._listening = sockets.create_server((_HOST, port), backlog=4)
        except OSError as error:
            raise OSError(f"{_HOST}:{port} (switch): {error.strerror}; choose another switch_port") from None
        self._listening.setblocking(False)
        self._host: sockets.socket | None = None
        self._reader = FrameReader()
        self._sequence = 0
        self._due_s = -math.inf

    @property
    def port(self) -> int:
        """Port that the site opens."""
        port: int = self._listening.getsockname()[1]
        return port

    @property
    def connected(self) -> bool:
        """Whether a site has the line open."""
        return self._host is not None

    def step(self, now_s: float, report: PatientSwitchState | None) -> None:
        """Answer the site's requests, and send a report if there is one and it is due at `now_s`, s."""
        with contextlib.suppress(BlockingIOError):
            host, _ = self._listening.accept()
            host.setblocking(False)
            host.setsockopt(sockets.IPPROTO_TCP, sockets.TCP_NODELAY, 1)
            self._hang_up()
            self._host, self._reader = host, FrameReader()
        try:
            for _ in range(self._requests()):
                self._send(MessageId.IDENTITY, _IDENTITY.encode())
            if report is not None and now_s >= self._due_s:
                self._due_s = max(self._due_s + 1.0 / RATE_HZ, now_s)
                self._send(PatientSwitchState.ID, report.encode())
        except OSError as error:  # a full buffer too: its host no longer reads, and must not get old reports later
            log.info("the site's line is closed: %s", error)
            self._hang_up()

    def close(self) -> None:
        """Release the port."""
        self._hang_up()
        self._listening.close()

    def _requests(self) -> int:
        """Return the number of complete requests for the identity; other frames are not for a switch."""
        if self._host is None:
            return 0
        try:
            chunk = self._host.recv(_CHUNK)
        except BlockingIOError:
            return 0
        if not chunk:
            raise ConnectionResetError("the site has closed it")
        return sum(frame.message_id == MessageId.IDENTIFY and not frame.payload for frame in self._reader.feed(chunk))

    def _send(self, message_id: MessageId, payload: bytes) -> None:
        if self._host is None:
            return
        frame = encode_frame(message_id, self._sequence, payload)
        self._sequence = (self._sequence + 1) & 0xFF
        if self._host.send(frame) != len(frame):
            raise OSError("its buffer is full")

    def _hang_up(self) -> None:
        if self._host is not None:
            self._host.close()
            self._host = None
