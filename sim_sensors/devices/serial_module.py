"""Base of the simulated serial modules: frames, identity, periodic reports, and the command watchdog.

A module depends on no port, clock or physics. It takes bytes of the host with their time of arrival and returns bytes
for the host. The simulated world connects its measurements and its drives.
"""

import math
from abc import ABC, abstractmethod

from common.buses.serial_framing import Frame, FrameReader, encode_frame
from common.buses.serial_messages import BadPayload, Identity, MessageId
from common.limits import MODULE_TIMEOUT_S

_EARLY_S = 1e-9
"""Tolerance of a report's time, s; times are sums of steps and carry rounding errors."""


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


class ReportClock:
    """Clock of a periodic report; after a pause of the module, one report is due, not a burst.

    Attributes:
        due_s: time from which a report is due, s.
    """

    def __init__(self, period_s: float, start_s: float) -> None:
        self._period_s = period_s
        self._due_s = start_s
        self.due_s = start_s - _EARLY_S

    def due(self, now_s: float) -> bool:
        """Return whether a report is due at `now_s`; if so, the next one is due a period later."""
        if now_s < self.due_s:
            return False
        self._due_s = max(self._due_s, now_s - self._period_s) + self._period_s
        self.due_s = self._due_s - _EARLY_S
        return True


class CommandWatchdog:
    """Watchdog of the commands, armed from power-up: 100 ms after the last valid command the drives go to 0.

    Attributes:
        expired: whether no command is in force.
        limit_s: time at which the latest command expires, s.
        due_s: the same while a command is in force, otherwise infinite.
    """

    def __init__(self) -> None:
        self.expired = True
        self.limit_s = 0.0
        self.due_s = math.inf

    def obeyed(self, now_s: float) -> None:
        """Start the time again for a valid command at `now_s`."""
        self.expired = False
        self.limit_s = self.due_s = now_s + MODULE_TIMEOUT_S

    def expires(self, now_s: float) -> bool:
        """Return whether the command in force expires by `now_s`; each expiry returns True only once."""
        if now_s < self.due_s:
            return False
        self.expired = True
        self.due_s = math.inf
        return True


class CutOut:
    """Temperature limit inside a module: it interrupts the supply of a drive by the module's own measurement.

    It acts behind the command path, so it also protects against a stuck driver. It releases 1 K below the limit, and
    only while the drive that it interrupts does not heat.
    """

    RELEASE_K = 1.0
    PERIOD_S = 0.010
    """Time between two measurements, s."""
    RATE_LAG_S = 0.1
    FASTEST_K_S = 8.0
    """Fastest possible heating of a plate, K/s; a faster rise of the reading is a jump and is limited to this."""

    def __init__(self, limit_c: float, look_ahead_s: float = 0.0) -> None:
        """Limit a plate to `limit_c` by its predicted temperature in `look_ahead_s`, because its sensor lags."""
        self._limit_c = limit_c
        self._look_ahead_s = look_ahead_s
        self._measured_c = math.nan
        self._rate_k_s = 0.0
        self.tripped = False

    def measure(self, measured_c: float) -> None:
        """Take a measurement, C, once each PERIOD_S; NaN if there is none."""
        rate = (measured_c - self._measured_c) / self.PERIOD_S
        known = math.isfinite(rate)
        rate = max(-self.FASTEST_K_S, min(self.FASTEST_K_S, rate))
        self._rate_k_s += (rate - self._rate_k_s) * self.PERIOD_S / self.RATE_LAG_S if known else -self._rate_k_s
        self._measured_c = measured_c

    def allows(self, drive_permille: int) -> bool:
        """Return whether the commanded drive may pass; a missing measurement trips the cut-out."""
        ahead_c = self._measured_c + self._look_ahead_s * max(0.0, self._rate_k_s)
        if not ahead_c < self._limit_c:
            self.tripped = True
        elif drive_permille <= 0 and ahead_c < self._limit_c - self.RELEASE_K:
            self.tripped = False
        return not self.tripped
