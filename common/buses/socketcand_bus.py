"""Connects to a socketcand gateway with python-can's handshake, then sends and receives frames without waiting.

The library's client does not notice when the gateway ends. It waits without a limit for a gateway that stops reading.
It takes 80 us for the frames of a tick.
"""

import math
import re
import select
import socket
from collections import deque
from collections.abc import Iterable
from functools import cached_property

import can
from can.interfaces.socketcand import SocketCanDaemonBus
from can.interfaces.socketcand.socketcand import convert_ascii_message_to_can_message

from common.buses import tcp_options
from common.buses.can_frames import SentFrame

ANSWER_S = 1.0
"""Maximum wait for a gateway's answer, s; a gateway that is silent for longer counts as absent."""
_CHUNK = 4096
_LONGEST_TEXT = 200
"""Maximum length of one frame's text, characters; a longer text without an end is no frame."""
_SOCKET = "_SocketCanDaemonBus__socket"
"""Private name of the library's socket, to which it offers no access."""
_QUICKACK = getattr(socket, "TCP_QUICKACK", None)
"""Socket option for an immediate acknowledgement; None where the system has none. A gateway with Nagle's algorithm
waits for it before it sends more. It is only needed where nothing is sent: sent data carry an acknowledgement along."""


_FRAME = re.compile(r"< frame ([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8}) ([0-9]{1,20}\.[0-9]{1,20}) ([0-9A-Fa-f]+) >")
"""Identifier, time, s, and data of a frame as gateways write it."""

TakenFrame = tuple[float, int, bytes, bool, bool]
"""A received frame: bus time, s; identifier; data; whether the identifier has 29 bits; whether it is an error frame.
The library's own messages take far longer to create."""


class GatewayBus(SocketCanDaemonBus):
    """One connection to a gateway; once open, sending, and receiving with timeout 0, do not block."""

    def __init__(self, channel: str, host: str, port: int) -> None:
        """Connect; blocks until the gateway has answered, at most a few seconds.

        Raises:
            can.CanError, OSError: the gateway is absent, or has no such channel.
        """
        self._frames: deque[TakenFrame] = deque()
        """Received frames for the library's `recv`, which returns one at a time."""
        self._text = ""
        """Start of an incomplete frame."""
        self._answered = False
        """Whether something was sent since frames were last taken."""
        self._unsent = b""
        """Rest of a frame that the system took in part."""
        _ask(host, port)
        try:
            super().__init__(channel, host, port, tcp_tune=True)
        except (can.CanError, OSError):
            if hasattr(self, _SOCKET):
                self._connection.close()
            raise
        tcp_options.tune(self._connection)

    @cached_property
    def _connection(self) -> socket.socket:
        connection: socket.socket = getattr(self, _SOCKET)
        return connection

    def fileno(self) -> int:
        """Return the descriptor of the connection."""
        return self._connection.fileno()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame without waiting; `timeout` is ignored.

        Raises:
            can.CanTimeoutError: the gateway takes no data now; the frame is not sent.
            OSError: the connection has ended.
        """
        width = 8 if msg.is_extended_id else 3
        self._write(f"< send {msg.arbitration_id:0{width}X} {msg.dlc:X} {msg.data.hex(' ')} >")

    def send_all(self, frames: Iterable[SentFrame]) -> None:
        """Send frames in one call; raises as `send`, and then none of them is sent."""
        self._write("".join([f"< send {frame_id:03X} {len(data):X} {data.hex(' ')} >" for frame_id, data in frames]))

    def _write(self, text: str) -> None:
        if self._unsent:
            self._unsent = self._rest_of(self._unsent)
        if not self._unsent:
            data = text.encode("ascii")
            rest = self._rest_of(data)
            if len(rest) < len(data):
                self._unsent, self._answered = rest, True
                return
        raise can.CanTimeoutError("the gateway takes nothing")

    def _rest_of(self, data: bytes) -> bytes:
        """Send bytes and return those that the system does not take now."""
        try:
            return data[self._connection.send(data, socket.MSG_DONTWAIT) :]
        except BlockingIOError:
            return data

    def take_some(self) -> tuple[list[TakenFrame], bool]:
        """Return frames that have arrived, at most _CHUNK bytes of them, and whether more may wait.

        Raises:
            can.CanError: the gateway has closed the connection, or sent something that is no frame.
        """
        connection = self._connection
        try:
            chunk = connection.recv(_CHUNK, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return [], False
        if not chunk:
            raise can.CanOperationError("the gateway has hung up")
        if _QUICKACK is not None and not self._answered:
            connection.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
        self._answered = False
        try:
            frames = self._read(self._text + chunk.decode("ascii"))
        except ValueError as error:
            raise can.CanError(f"the gateway sent an invalid frame: {error}") from None
        if len(self._text) > _LONGEST_TEXT:
            self._text = ""
        return frames, len(chunk) == _CHUNK

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._frames and (timeout == 0 or self._readable(timeout)):
            self._frames.extend(self.take_some()[0])
        return (_message(self._frames.popleft()) if self._frames else None), False

    def _readable(self, timeout_s: float | None) -> bool:
        """Wait for data of the gateway, at most `timeout_s`, s; return whether there are any."""
        poll = select.poll()  # takes descriptors of any number, unlike `select`
        poll.register(self._connection, select.POLLIN)
        return bool(poll.poll(None if timeout_s is None else timeout_s * 1e3))

    def _read(self, text: str) -> list[TakenFrame]:
        """Return the complete frames of a text; keep the incomplete rest in `_text`.

        Raises:
            ValueError: identifier, time or bytes of a frame cannot be read.
        """
        parts = _FRAME.split(text)
        if ">" not in parts[-1] and not any(parts[:-1:4]):  # the text has frames and nothing else
            self._text = parts[-1]
            return [
                (float(sent_s), int(identifier, 16), bytes.fromhex(data), len(identifier) != 3, False)
                for identifier, sent_s, data in zip(parts[1::4], parts[2::4], parts[3::4], strict=True)
            ]
        *texts, self._text = text.split(">")
        return [frame for each in texts if (frame := _frame(each)) is not None]

    def _expect_msg(self, msg: str) -> None:
        if not self._readable(ANSWER_S):
            raise can.CanTimeoutError(f"the gateway does not answer with {msg!r}")
        try:
            super()._expect_msg(msg)
        except UnicodeDecodeError:
            raise can.CanInitializationError("the gateway answers with bytes that are no text") from None


def _message(frame: TakenFrame) -> can.Message:
    timestamp, arbitration_id, data, extended, is_error = frame
    return can.Message(timestamp, arbitration_id, extended, is_error_frame=is_error, data=data)


def taken_frame(message: can.Message) -> TakenFrame:
    """Convert one of the library's messages."""
    return (
        message.timestamp,
        message.arbitration_id,
        bytes(message.data),
        message.is_extended_id,
        message.is_error_frame,
    )


def _frame(text: str) -> TakenFrame | None:
    """Return the frame, or error frame, that a gateway wrote before `>`; None where it is something else.

    Raises:
        ValueError: identifier, time or bytes of a frame cannot be read.
    """
    try:
        found: can.Message | None = convert_ascii_message_to_can_message(f"{text[text.find('<') :]}>")
    except IndexError:
        raise ValueError("a part of it is missing") from None
    if found is None:
        return None
    if not math.isfinite(found.timestamp):
        raise ValueError(f"its time is {found.timestamp}")
    return taken_frame(found)


def _ask(host: str, port: int) -> None:
    """Check that a gateway listens and answers; without one the library retries for 10 s and uses a whole core."""
    with socket.create_connection((host, port), timeout=ANSWER_S) as connection:
        if not connection.recv(16).startswith(b"< hi"):
            raise can.CanInitializationError("the peer is no socketcand gateway")
