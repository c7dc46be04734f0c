"""What every simulated serial module does: frames, identity, reports at a rate, and the command watchdog.

A module is a machine of bytes and times. It knows no port, no clock and no physics: bytes of the host go in
with the time at which they came, bytes for the host come out, and the world connects what the module
measures and drives.
"""

import math
from abc import ABC, abstractmethod

from common.framing import Frame, FrameReader, encode_frame
from common.limits import MODULE_TIMEOUT_S
from common.serial_messages import BadPayload, Identity, MessageId

_EARLY_S = 1e-9
"""A clock that has not quite reached a report's moment has reached it: times are sums of steps."""


class SerialModule(ABC):
    """Base of the emulated modules.

    Attributes:
        identity: what it answers to IDENTIFY.
        refused: good frames whose content was out of range, or that this kind of module does not know.
        reader: what came in, with the count of damaged frames.
        due_s: earliest moment at which it acts without being fed, s.
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
        """Take bytes from the host that arrived at `now_s`, in whatever pieces they come."""
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
        """Let the module's own clock reach `now_s`; return the bytes that it has for the host."""
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
        """Carry a command out; raises BadPayload on one that this module does not accept."""

    @abstractmethod
    def _run(self, now_s: float) -> None:
        """Do what is due by `now_s`: watchdog, limits, reports."""

    @abstractmethod
    def _next_s(self) -> float:
        """When something is due next, after `_run`, s."""


class ReportClock:
    """Says when the next periodic report is due; a module that was not asked for a while sends one, not a burst.

    Attributes:
        due_s: moment from which a report is due, s.
    """

    def __init__(self, period_s: float, start_s: float) -> None:
        self._period_s = period_s
        self._due_s = start_s
        self.due_s = start_s - _EARLY_S

    def due(self, now_s: float) -> bool:
        """Whether a report is due at `now_s`; if so, the next one is a period later."""
        if now_s < self.due_s:
            return False
        self._due_s = max(self._due_s, now_s - self._period_s) + self._period_s
        self.due_s = self._due_s - _EARLY_S
        return True


class CommandWatchdog:
    """Armed from power-up: without a valid command for 100 ms the module's drives go to 0.

    Attributes:
        expired: no command is in force.
        limit_s: moment at which the command in force runs out.
        due_s: the same, infinite while no command is in force.
    """

    def __init__(self) -> None:
        self.expired = True
        self.limit_s = 0.0
        self.due_s = math.inf

    def obeyed(self, now_s: float) -> None:
        """A valid command came."""
        self.expired = False
        self.limit_s = self.due_s = now_s + MODULE_TIMEOUT_S

    def expires(self, now_s: float) -> bool:
        """Whether the command in force runs out by `now_s`; says so once."""
        if now_s < self.due_s:
            return False
        self.expired = True
        self.due_s = math.inf
        return True


class CutOut:
    """A module's own temperature limit: interrupts the supply of a drive by the module's own measurement.

    It stands behind the command path, so that it also holds against a driver that is stuck. It lets go again 1 K below
    the limit, and only once the drive that it holds back does not heat.
    """

    RELEASE_K = 1.0
    PERIOD_S = 0.010
    """Between two measurements."""
    RATE_LAG_S = 0.1
    FASTEST_K_S = 8.0
    """No plate is heated faster: a reading that jumps has not been heated."""

    def __init__(self, limit_c: float, look_ahead_s: float = 0.0) -> None:
        """Limit a plate to `limit_c`, by where it will be in `look_ahead_s`: its sensor is behind it."""
        self._limit_c = limit_c
        self._look_ahead_s = look_ahead_s
        self._measured_c = math.nan
        self._rate_k_s = 0.0
        self.tripped = False

    def measure(self, measured_c: float) -> None:
        """Take a measurement, one each PERIOD_S; NaN where there is none to be had."""
        rate = (measured_c - self._measured_c) / self.PERIOD_S
        known = math.isfinite(rate)
        rate = max(-self.FASTEST_K_S, min(self.FASTEST_K_S, rate))
        self._rate_k_s += (rate - self._rate_k_s) * self.PERIOD_S / self.RATE_LAG_S if known else -self._rate_k_s
        self._measured_c = measured_c

    def allows(self, drive_permille: int) -> bool:
        """Whether the drive that is asked for may go through; a plate that is not measured trips."""
        ahead_c = self._measured_c + self._look_ahead_s * max(0.0, self._rate_k_s)
        if not ahead_c < self._limit_c:
            self.tripped = True
        elif drive_permille <= 0 and ahead_c < self._limit_c - self.RELEASE_K:
            self.tripped = False
        return not self.tripped
