"""A conversation with one serial module: whole frames with their times, and frames that are wrong on purpose."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from common.framing import Frame, FrameReader, encode_frame
from common.serial_messages import BadPayload, DeviceKind, Identity, MessageId
from common.serial_port import BAUD, DeviceAbsent, open_port

ANSWER_S = 0.1
"""An IDENTIFY is answered within this time."""
REST_S = 3.0
"""Listened to at rest: the sequence number of the slowest reports wraps within it."""
REPORTS = {
    DeviceKind.TEXTURE_SENSOR: MessageId.TEXTURE_SAMPLES,
    DeviceKind.THERMAL_SENSOR: MessageId.THERMAL_READING,
    DeviceKind.TACTTIP: MessageId.TACTTIP_STATE,
}
_READ_S = 0.002
_FULL_S = 0.5


class ModuleEnd(Protocol):
    """The host's end of a line, and the clock that goes with it."""

    address: str

    def now(self) -> float:
        """Time of the host, s."""

    def send(self, data: bytes) -> None:
        """Put bytes on the line."""

    def receive(self, seconds: float) -> Iterator[tuple[float, bytes]]:
        """Bytes that come within so many seconds, each piece at once, with its time of arrival."""

    def look_away(self, seconds: float) -> None:
        """Let time go by without reading."""


class PortEnd:
    """A serial port, a pseudo terminal, or a `socket://` address, in real time."""

    def __init__(self, address: str) -> None:
        """Open it, alone.

        Raises:
            DeviceAbsent: it cannot be opened, or another program has it.
        """
        self._port = open_port(address)
        self.address = address
        self.now = time.monotonic

    def send(self, data: bytes) -> None:
        """Put bytes on the line.

        Raises:
            DeviceAbsent: the line is gone, or took nothing for half a second.
        """
        until_s = self.now() + _FULL_S
        try:
            while data:
                taken = self._port.write(data)
                data = data[taken:]
                if taken:
                    until_s = self.now() + _FULL_S
                elif self.now() > until_s:
                    raise TimeoutError("the line takes nothing")
                else:
                    time.sleep(_READ_S)
        except OSError as error:
            raise DeviceAbsent(f"{self.address}: {error}") from None

    def receive(self, seconds: float) -> Iterator[tuple[float, bytes]]:
        """Bytes that come, in pieces of 2 ms.

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
        """Let time go by without reading."""
        time.sleep(seconds)

    def close(self) -> None:
        """Give the port back."""
        self._port.close()


@dataclass(frozen=True, slots=True)
class Heard:
    """A good frame and when it came."""

    at_s: float
    frame: Frame


@dataclass(frozen=True, slots=True)
class Span:
    """What was heard in one go."""

    frames: Sequence[Heard]
    damaged: int
    """Pieces between two zero bytes that were no frame."""

    def of(self, message_id: MessageId) -> list[Heard]:
        """The frames of one message."""
        return [heard for heard in self.frames if heard.frame.message_id == message_id]


class ModuleTalk:
    """One module on trial.

    Attributes:
        end: the line.
        kind: what it is told to be, or else says it is.
        told_finger: number of the finger that the user named; None: any.
        told_kind: kind that the user named; None: any.
        identity: its first answer to IDENTIFY.
        watch: looks at every good frame as it comes; raises Unsafe.
    """

    def __init__(self, end: ModuleEnd, told_kind: DeviceKind | None = None, told_finger: int | None = None) -> None:
        """Ask it who it is.

        Raises:
            DeviceAbsent: nothing answers, and `told_kind` does not say what it is either.
        """
        self.end = end
        self.told_kind, self.told_finger = told_kind, told_finger
        self.watch: Callable[[Frame], None] = lambda frame: None
        self._reader = FrameReader()
        self._sequence = 0
        # A zero byte ends what a host before may have left; what had driven the module ends by itself meanwhile.
        end.send(b"\0")
        self.begin_anew(0.3)
        self.identity = self._who()
        self.kind = told_kind or (self.identity and self.identity.kind) or DeviceKind.TACTTIP

    @cached_property
    def at_rest(self) -> Span:
        """What it says by itself, without any command."""
        self.begin_anew()
        return self.listen(REST_S)

    @property
    def rate_hz(self) -> float:
        """Reports a second that it should send."""
        return 200.0 if self.kind is DeviceKind.TEXTURE_SENSOR else 100.0

    def reports(self, span: Span) -> list[Heard]:
        """The reports of its kind."""
        return span.of(REPORTS[self.kind])

    def begin_anew(self, seconds: float = 0.02) -> None:
        """Forget what comes for so long, and half a frame: the next one is counted from its delimiter."""
        for _, piece in self.end.receive(seconds):
            self._reader.feed(piece)

    def listen(self, seconds: float) -> Span:
        """What comes within so many seconds, each frame looked at as it comes."""
        frames, before = [], self._reader.damaged
        for at_s, piece in self.end.receive(seconds):
            for frame in self._reader.feed(piece):
                self.watch(frame)
                frames.append(Heard(at_s, frame))
        return Span(frames, self._reader.damaged - before)

    def say(self, message_id: int, payload: bytes = b"") -> None:
        """Send a good frame."""
        self.end.send(self.frame(message_id, payload))

    def frame(self, message_id: int, payload: bytes = b"") -> bytes:
        """The bytes of the next good frame, with its delimiter."""
        self._sequence = (self._sequence + 1) & 0xFF
        return encode_frame(message_id, self._sequence, payload)

    def ask(self, within_s: float = ANSWER_S) -> list[float]:
        """Send IDENTIFY; how long its answers took that came in time, s."""
        asked_s = self.end.now()
        self.say(MessageId.IDENTIFY)
        return [heard.at_s - asked_s for heard in self.listen(within_s).of(MessageId.IDENTITY)]

    def _who(self) -> Identity | None:
        """Its answer to IDENTIFY; None if it gives no sound one within 1 s and `told_kind` says what it is."""
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
        if self.told_kind is not None:
            return None
        if not problem:
            problem = f"no answer to IDENTIFY within 1 s, {frames} other frames, {damaged_frames} damaged"
        if damaged_frames > frames:
            problem += f" (is it at {BAUD} baud?)"
        elif not frames:
            problem += " (is it powered, are RX and TX crossed?)"
        raise DeviceAbsent(f"{self.end.address}: {problem}; --device KIND tries a device that does not say what it is")


def damaged(frame: bytes) -> bytes:
    """The same frame with one bit wrong in its CRC, still good COBS."""
    at = len(frame) - 2
    wrong = frame[at] ^ (0x10 if frame[at] != 0x10 else 0x20)
    return frame[:at] + bytes((wrong,)) + frame[at + 1 :]
