"""Communicate with one serial module: timestamped frames, and frames that are deliberately wrong."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from common.buses.serial_messages import BadPayload, DeviceKind, Frame, FrameReader, Identity, MessageId, encode_frame
from common.buses.serial_port import BAUD, DeviceAbsent, open_port

ANSWER_S = 0.1
"""Time within which a module must answer IDENTIFY, s."""
REST_S = 3.0
"""Duration of listening at rest, s; the sequence number of the slowest reports wraps within it."""
REPORTS = {
    DeviceKind.TEXTURE_SENSOR: MessageId.TEXTURE_SAMPLES,
    DeviceKind.THERMAL_SENSOR: MessageId.THERMAL_READING,
    DeviceKind.TACTTIP: MessageId.TACTTIP_STATE,
    DeviceKind.PATIENT_SWITCH: MessageId.PATIENT_SWITCH_STATE,
}
_READ_S = 0.002
_FULL_S = 0.5


class PortEnd:
    """The host's end of a line, with the host's clock: a serial port, a pseudo terminal, or a `socket://` address."""

    def __init__(self, address: str) -> None:
        """Open the port for exclusive use.

        Raises:
            DeviceAbsent: the port cannot be opened, or another program uses it.
        """
        self._port = open_port(address)
        self.address = address
        self.now = time.monotonic

    def send(self, data: bytes) -> None:
        """Put bytes on the line; raises DeviceAbsent where the line is gone, or accepted no bytes for half a second."""
        until_s = self.now() + _FULL_S
        try:
            while data:
                taken = self._port.write(data)
                data = data[taken:]
                if taken:
                    until_s = self.now() + _FULL_S
                elif self.now() > until_s:
                    raise TimeoutError("the line accepts no bytes")
                else:
                    time.sleep(_READ_S)
        except OSError as error:
            raise DeviceAbsent(f"{self.address}: {error}") from None

    def receive(self, seconds: float) -> Iterator[tuple[float, bytes]]:
        """Yield the bytes of the next `seconds` with their time of arrival, s, read at least every 2 ms.

        Raises:
            DeviceAbsent: the line is gone.
        """
        until_s = self.now() + seconds
        while self.now() < until_s:
            try:
                piece = self._port.read() if self._port.wait(_READ_S) else b""
            except OSError as error:
                raise DeviceAbsent(f"{self.address}: {error}") from None
            if piece:
                yield self.now(), piece

    def look_away(self, seconds: float) -> None:
        """Wait for `seconds` without reading."""
        time.sleep(seconds)

    def close(self) -> None:
        """Close the port."""
        self._port.close()


@dataclass(frozen=True, slots=True)
class ReceivedFrame:
    """An intact frame and its time of arrival, s."""

    at_s: float
    frame: Frame


@dataclass(frozen=True, slots=True)
class Span:
    """Everything received in one interval."""

    frames: Sequence[ReceivedFrame]
    damaged: int
    """Number of pieces between two zero bytes that were no frame."""

    def of(self, message_id: MessageId) -> list[ReceivedFrame]:
        """Return the frames of one message."""
        return [heard for heard in self.frames if heard.frame.message_id == message_id]


class ModuleTalk:
    """One module on trial.

    Attributes:
        end: the line.
        kind: the expected kind, or else the kind that the module reports.
        expected_finger: index of the finger that the user specified; None: any.
        expected_kind: kind that the user specified; None: any.
        identity: its first answer to IDENTIFY.
        watch: called with every intact frame as it arrives; raises Unsafe.
    """

    def __init__(
        self, end: PortEnd, expected_kind: DeviceKind | None = None, expected_finger: int | None = None
    ) -> None:
        """Ask the module for its identity; raises DeviceAbsent without an answer and without `expected_kind`."""
        self.end = end
        self.expected_kind, self.expected_finger = expected_kind, expected_finger
        self.watch: Callable[[Frame], None] = lambda frame: None
        self._reader = FrameReader()
        self._sequence = 0
        # A zero byte ends a frame that an earlier host may have left incomplete. Meanwhile, its commands time out.
        end.send(b"\0")
        self.begin_anew(0.3)
        self.identity = self._who()
        self.kind = expected_kind or (self.identity and self.identity.kind) or DeviceKind.TACTTIP

    @cached_property
    def at_rest(self) -> Span:
        """Everything that the module sends without a command."""
        self.begin_anew()
        return self.listen(REST_S)

    @property
    def rate_hz(self) -> float:
        """Required number of reports a second."""
        return 200.0 if self.kind is DeviceKind.TEXTURE_SENSOR else 100.0

    def reports(self, span: Span) -> list[ReceivedFrame]:
        """Return the reports of the module's kind."""
        return span.of(REPORTS[self.kind])

    def begin_anew(self, seconds: float = 0.02) -> None:
        """Discard everything that arrives for `seconds`; counting then starts at the next delimiter."""
        for _, piece in self.end.receive(seconds):
            self._reader.feed(piece)

    def listen(self, seconds: float) -> Span:
        """Return everything that arrives within `seconds`; `watch` sees each frame on arrival."""
        frames, before = [], self._reader.damaged
        for at_s, piece in self.end.receive(seconds):
            for frame in self._reader.feed(piece):
                self.watch(frame)
                frames.append(ReceivedFrame(at_s, frame))
        return Span(frames, self._reader.damaged - before)

    def say(self, message_id: int, payload: bytes = b"") -> None:
        """Send a correct frame."""
        self.end.send(self.frame(message_id, payload))

    def frame(self, message_id: int, payload: bytes = b"") -> bytes:
        """Return the bytes of the next correct frame, with its delimiter."""
        self._sequence = (self._sequence + 1) & 0xFF
        return encode_frame(message_id, self._sequence, payload)

    def ask(self, within_s: float = ANSWER_S) -> list[float]:
        """Send IDENTIFY; return the response times of the answers within `within_s`, s."""
        asked_s = self.end.now()
        self.say(MessageId.IDENTIFY)
        return [heard.at_s - asked_s for heard in self.listen(within_s).of(MessageId.IDENTITY)]

    def _who(self) -> Identity | None:
        """Return the answer to IDENTIFY; None without a valid answer within 1 s if `expected_kind` is given."""
        self.say(MessageId.IDENTIFY)
        frames, damaged_frames, problem = 0, 0, ""
        for _ in range(10):
            span = self.listen(0.1)
            frames, damaged_frames = frames + len(span.frames), damaged_frames + span.damaged
            for heard in span.of(MessageId.IDENTITY):
                try:
                    return Identity.decode(heard.frame.payload)
                except BadPayload as error:
                    problem = str(error)
        if self.expected_kind is not None:
            return None
        if not problem:
            problem = f"no answer to IDENTIFY within 1 s, {frames} other frames, {damaged_frames} damaged"
        if damaged_frames > frames:
            problem += f" (is it at {BAUD} baud?)"
        elif not frames:
            problem += " (is it powered, are RX and TX crossed?)"
        raise DeviceAbsent(f"{self.end.address}: {problem}; --device KIND tries a device that does not identify itself")


def damaged(frame: bytes) -> bytes:
    """Return the frame with one wrong bit in its CRC; its COBS is still valid."""
    at = len(frame) - 2
    wrong = frame[at] ^ (0x10 if frame[at] != 0x10 else 0x20)
    return frame[:at] + bytes((wrong,)) + frame[at + 1 :]
