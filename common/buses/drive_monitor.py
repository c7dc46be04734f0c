"""Compares the outputs that a device reports with the commands, and finds outputs that were not commanded.

No output at all is always right, because the device's own time-out and limits may turn it off. A device that reports
for long that no command is in force receives none.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from common.faults.fault import UNITS, Fault, FaultCode
from common.fingers import FINGERS
from common.limits import MODULE_TIMEOUT_S

MEMORY_S = 0.15
"""Time that a command may act after the next one was sent, s: line, device, ramp, and the report back."""
PERSIST_S = 0.10
"""Duration of wrong reports that is a fault, s."""
LONGEST_S = 0.02
"""Maximum time that counts between two reports, s: after a standstill of the site, reports are outdated."""
FORGIVEN = 0.5
"""Share of the time of right reports that is subtracted, so that an alternating output is also found."""
NEAR_N = 0.1
"""Maximum difference between a right force and the commanded one, N."""
UNHEARD_S = 0.3
"""Duration of reports without a command in force, s, after which a device receives no commands."""
UNREPORTED_FRAMES = 250
"""Number of place frames without a state frame, 0.5 s, after which a CAN node is faulty."""


@dataclass(slots=True)
class Doubt:
    """Adds up the time for which reports were wrong. Pure: times, s, in."""

    _wrong_s: float = 0.0
    _before_s: float | None = None
    """Time between the last right report and the first wrong one, s; None without doubt."""
    _reported_s: float | None = None

    def step(self, t_s: float, wrong: bool) -> bool:
        """Take a report at its time; return whether reports have been wrong for too long."""
        if not (wrong or self._wrong_s):  # as nearly always: right, and so was all before it
            self._reported_s, self._before_s = t_s, None
            return False
        since_s = 0.0 if self._reported_s is None else min(max(0.0, t_s - self._reported_s), LONGEST_S)
        self._reported_s = t_s
        if not wrong:
            self._wrong_s = max(0.0, self._wrong_s - FORGIVEN * since_s)
            self._before_s = self._before_s if self._wrong_s > 0.0 else None
            return False
        if self._before_s is None:
            self._before_s = since_s
        self._wrong_s += since_s
        return self._wrong_s >= PERSIST_S + self._before_s - 1e-9


@dataclass(slots=True)
class DriveMonitor:
    """Watches one output that takes one of the commanded values. Pure: numbers and times, s, in."""

    code: FaultCode
    """Code of the fault of an output that was not commanded."""
    _commanded: deque[tuple[float, int]] = field(default_factory=deque)
    _doubt: Doubt = field(default_factory=Doubt)

    def commanded(self, t_s: float, drive: int) -> None:
        """Take a command that was sent; 0 is no output."""
        if self._commanded and self._commanded[-1][1] == drive:
            return  # it stays in force
        self._commanded.append((t_s, drive))
        _forget(self._commanded, t_s)  # a device that is away for hours reports nothing, and still gets commands

    def reported(self, t_s: float, drive: int) -> Fault | None:
        """Take the reported output; return its fault, None without one."""
        _forget(self._commanded, t_s)
        wrong = drive != 0
        if wrong:
            for _, sent in reversed(self._commanded):  # it is mostly one of the newest
                if sent == drive:
                    wrong = False
                    break
        if not self._doubt.step(t_s, wrong):
            return None
        return Fault(self.code, value=float(drive) if self.code in UNITS else None)


class ForceMonitor:
    """Watches the force on each finger; between two commands every force in their range is right.

    Pure: forces, N, and times, s, in.
    """

    def __init__(self) -> None:
        self._commanded: deque[tuple[float, Sequence[float]]] = deque()
        self._doubts = [Doubt() for _ in FINGERS]

    def commanded(self, t_s: float, force_n: Sequence[float]) -> None:
        """Take commanded forces, (5,), N."""
        commanded_n = tuple(force_n)
        if self._commanded and self._commanded[-1][1] == commanded_n:
            return  # they stay in force
        self._commanded.append((t_s, commanded_n))
        _forget(self._commanded, t_s)

    def reported(self, t_s: float, force_n: Sequence[float]) -> list[Fault]:
        """Take the reported forces, (5,), N; return their faults."""
        _forget(self._commanded, t_s)
        found = []
        for index, (finger, applied_n, doubt) in enumerate(zip(FINGERS, force_n, self._doubts, strict=True)):
            if not applied_n > 0.0:
                doubt.step(t_s, False)
                continue
            low_n, high_n = self._asked_n(index, applied_n)
            if doubt.step(t_s, not _near(applied_n, low_n, high_n)):
                nearest_n = min(high_n, max(low_n, applied_n))
                found.append(Fault(FaultCode.FORCE_UNASKED, finger, value=applied_n, limit=nearest_n))
        return found

    def _asked_n(self, index: int, applied_n: float) -> tuple[float, float]:
        """Return the lowest and highest force in effect of one finger, N; the search ends at one near `applied_n`."""
        low_n, high_n = math.inf, -math.inf
        for _, commanded_n in reversed(self._commanded):
            asked_n = commanded_n[index]
            low_n, high_n = min(low_n, asked_n), max(high_n, asked_n)
            if _near(applied_n, low_n, high_n):
                break
        return (low_n, high_n) if self._commanded else (0.0, 0.0)


@dataclass(slots=True)
class CommandMonitor:
    """Watches that a device receives the commands that are sent to it. Pure: times, s, in.

    Attributes:
        deaf: whether it has reported for UNHEARD_S that no command is in force, although commands were sent.
    """

    deaf: bool = False
    _sent_s: float = -math.inf
    _since_s: float | None = None

    def commanded(self, t_s: float) -> None:
        """Note that a command was sent."""
        self._sent_s = t_s

    def reported(self, t_s: float, received: bool) -> None:
        """Take a report, and whether it says that a command is in force."""
        if received or not 0.0 <= t_s - self._sent_s <= MODULE_TIMEOUT_S:
            self._since_s = None
        elif self._since_s is None:
            self._since_s = t_s
        self.deaf = self._since_s is not None and t_s - self._since_s >= UNHEARD_S


@dataclass(slots=True)
class ReportMonitor:
    """Watches that a CAN node keeps reporting its outputs. It counts frames, not time: a line may be late."""

    _places: int = 0
    _states: int = 0
    _places_at_state: int = 0

    def step(self, places: int, states: int) -> None:
        """Take the numbers of place frames and state frames that have arrived in all."""
        self._places = places
        if states != self._states:
            self._states, self._places_at_state = states, places

    @property
    def fault(self) -> Fault | None:
        """The fault of a node that reports no state; None without one."""
        missing = self._places - self._places_at_state > UNREPORTED_FRAMES
        return Fault(FaultCode.STATE_NOT_REPORTED) if missing else None


def _near(applied_n: float, low_n: float, high_n: float) -> bool:
    return low_n - NEAR_N <= applied_n <= high_n + NEAR_N


def _forget(commands: deque[tuple[float, int]] | deque[tuple[float, Sequence[float]]], t_s: float) -> None:
    while len(commands) > 1 and t_s - commands[1][0] > MEMORY_S:
        commands.popleft()
