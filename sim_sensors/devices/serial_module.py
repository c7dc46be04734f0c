"""Base of the simulated serial modules: frames, identity, and the host's commands.

A module depends on no port, clock or physics. It takes bytes of the host with their time of arrival and returns bytes
for the host. The simulated world connects its measurements and its drives.
"""

import math
from abc import ABC, abstractmethod

from common.buses.serial_messages import BadPayload, Frame, FrameReader, Identity, MessageId, encode_frame


class SerialModule(ABC):
    """Base of the emulated modules.

    Attributes:
        identity: its answer to IDENTIFY.
        refused: number of intact frames with content out of range, or unknown to this kind of module.
        reader: reader of the incoming frames, with the count of damaged ones.
        due_s: earliest time at which it acts without being fed, s.
    """

    def __init__(self, identity: Identity, powered_s: float = 0.0) -> None:
        self.identity = identity
        self.reader = FrameReader()
        self.refused = 0
        self.due_s = -math.inf
        self._powered_s = powered_s
        self._sequence = 0
        self._output = b""

    def feed(self, data: bytes, now_s: float) -> None:
        """Take bytes from the host that arrived at `now_s`; frames may come in pieces."""
        self.due_s = -math.inf
        for frame in self.reader.feed(data):
            try:
                if frame.message_id == MessageId.IDENTIFY:
                    self._answer(frame)
                else:
                    self._obey(frame, now_s)
            except BadPayload:
                self.refused += 1

    def take_output(self, now_s: float) -> bytes:
        """Advance the module to `now_s`; return its bytes for the host."""
        if now_s < self.due_s:
            return b""
        self._run(now_s)
        self.due_s = self._next_s()
        output, self._output = self._output, b""
        return output

    def _answer(self, frame: Frame) -> None:
        if frame.payload:
            raise BadPayload(f"identify: {len(frame.payload)} bytes, expected 0")
        self._say(MessageId.IDENTITY, self.identity.encode())

    def _say(self, message_id: MessageId, payload: bytes) -> None:
        self._output += encode_frame(message_id, self._sequence, payload)
        self._sequence = (self._sequence + 1) & 0xFF

    def _time_us(self, now_s: float) -> int:
        return round((now_s - self._powered_s) * 1e6)

    @abstractmethod
    def _obey(self, frame: Frame, now_s: float) -> None:
        """Execute a command; raise BadPayload for one that this module does not accept."""

    @abstractmethod
    def _run(self, now_s: float) -> None:
        """Apply watchdog and limits and make the reports that are due by `now_s`."""

    @abstractmethod
    def _next_s(self) -> float:
        """Return the time of the next due action after `_run`, s."""
