"""The connection to a socketcand gateway: python-can's own handshake, then frames without waiting.

The library's client does not notice the gateway's end, waits without end for one that reads no more, and takes 80 us
for the frames of a tick.
"""

import select
import socket
from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

import can
from can.interfaces.socketcand import SocketCanDaemonBus
from can.interfaces.socketcand.socketcand import convert_ascii_message_to_can_message

from common import device_socket

ANSWER_S = 1.0
"""A gateway that says nothing for this long is not there."""
_CHUNK = 4096
_LONGEST_TEXT = 200
"""Characters of one frame; more of them without an end are no frame."""
_SOCKET = "_SocketCanDaemonBus__socket"
"""The library offers no way to its socket."""
_QUICKACK = getattr(socket, "TCP_QUICKACK", None)
"""Acknowledge at once: a gateway with Nagle's algorithm waits for it before it sends more."""


class TakenFrame(NamedTuple):
    """What a line reads of a frame: one of the library's own messages takes four times as long to make."""

    timestamp: float
    """When it was on the bus, by the bus's clock, s."""
    arbitration_id: int
    data: bytes
    is_extended_id: bool
    is_error_frame: bool = False


class GatewayBus(SocketCanDaemonBus):
    """One connection to a gateway; once it is open, sending and receiving with no timeout do not block."""

    def __init__(self, channel: str, host: str, port: int) -> None:
        """Connect; blocks until the gateway has answered, a few seconds at most.

        Raises:
            can.CanError, OSError: the gateway is not there, or has no such channel.
        """
        self._frames: deque[TakenFrame] = deque()
        self._text = ""
        """Of a frame that has not come to its end."""
        self._unsent = b""
        """The rest of a frame that the system has taken in part."""
        _ask(host, port)
        try:
            super().__init__(channel, host, port, tcp_tune=True)
        except (can.CanError, OSError):
            if hasattr(self, _SOCKET):
                self._connection.close()
            raise
        device_socket.tune(self._connection)

    @property
    def _connection(self) -> socket.socket:
        connection: socket.socket = getattr(self, _SOCKET)
        return connection

    def fileno(self) -> int:
        """Descriptor of the connection."""
        return self._connection.fileno()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame; nothing is waited for, whatever `timeout` says.

        Raises:
            can.CanTimeoutError: the gateway takes nothing at the moment; the frame is not sent.
            OSError: the connection has ended.
        """
        self.send_all([msg])

    def send_all(self, frames: Iterable[can.Message]) -> None:
        """Send frames in one go; raises as `send`, and then none of them is sent."""
        self._unsent = self._rest_of(self._unsent)
        text = b"".join([_frame_text(frame) for frame in frames])
        if not self._unsent:
            self._unsent = self._rest_of(text)
            if len(self._unsent) < len(text):
                return
            self._unsent = b""
        raise can.CanTimeoutError("the gateway takes nothing")

    def _rest_of(self, data: bytes) -> bytes:
        """What of these bytes the system does not take now."""
        try:
            return data[self._connection.send(data, socket.MSG_DONTWAIT) :] if data else b""
        except BlockingIOError:
            return data

    def take_some(self) -> tuple[list[TakenFrame], bool]:
        """Frames that have come, at most _CHUNK bytes of them, and whether there may be more.

        Raises:
            can.CanError: the gateway has hung up, or what it says is no frame.
        """
        more = self._receive() == _CHUNK
        frames = list(self._frames)
        self._frames.clear()
        return frames, more

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._frames and (timeout == 0 or select.select((self._connection,), (), (), timeout)[0]):
            self._receive()
        return (_message(self._frames.popleft()) if self._frames else None), False

    def _receive(self) -> int:
        """Take what has come; returns how many bytes that were.

        Raises:
            can.CanError: the gateway has hung up, or what it says is no frame.
        """
        try:
            chunk = self._connection.recv(_CHUNK, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return 0
        if not chunk:
            raise can.CanOperationError("the gateway has hung up")
        if _QUICKACK is not None:
            self._connection.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
        try:
            *texts, self._text = (self._text + chunk.decode("ascii")).split(">")
            frames = [_frame(text) for text in texts]
        except ValueError as error:
            raise can.CanError(f"the gateway says what is no frame: {error}") from None
        self._frames.extend(frame for frame in frames if frame is not None)
        if len(self._text) > _LONGEST_TEXT:
            self._text = ""
        return len(chunk)

    def _expect_msg(self, msg: str) -> None:
        if not select.select((self._connection,), (), (), ANSWER_S)[0]:
            raise can.CanTimeoutError(f"the gateway does not answer with {msg!r}")
        super()._expect_msg(msg)


def _message(frame: TakenFrame) -> can.Message:
    return can.Message(**frame._asdict())


def _frame(text: str) -> TakenFrame | None:
    """The frame, or error frame, that a gateway wrote before `>`; None where it is something else.

    Raises:
        ValueError: identifier, time or bytes of a frame cannot be read.
    """
    start = text.find("<")
    words = text[start:].split()
    if words[:2] != ["<", "frame"] or len(words) != 5:
        found: can.Message | None = convert_ascii_message_to_can_message(f"{text[start:]}>")
        if found is None:
            return None
        return TakenFrame(
            found.timestamp, found.arbitration_id, bytes(found.data), found.is_extended_id, found.is_error_frame
        )
    _, _, identifier, sent_s, data = words
    return TakenFrame(float(sent_s), int(identifier, 16), bytes.fromhex(data), len(identifier) != 3)


def _frame_text(frame: can.Message) -> bytes:
    identifier = f"{frame.arbitration_id:08X}" if frame.is_extended_id else f"{frame.arbitration_id:03X}"
    return f"< send {identifier} {frame.dlc:X} {frame.data.hex(' ')} >".encode("ascii")


def _ask(host: str, port: int) -> None:
    """Where nobody listens the library tries for 10 s without a pause, at a whole core's cost: so ask first."""
    with socket.create_connection((host, port), timeout=ANSWER_S) as connection:
        if not connection.recv(16).startswith(b"< hi"):
            raise can.CanInitializationError("what answers there is no socketcand gateway")
