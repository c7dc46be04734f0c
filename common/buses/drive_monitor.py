"""Compares what a device reports of its outputs with what it was sent, and finds outputs that nobody asked for.

No output at all is always right: the device's own time-out and limits may do so.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from common.faults.fault import UNITS, Fault, FaultCode
from common.fingers import FINGERS

MEMORY_S = 0.15
"""A command may still be in force this long after the next one was sent: line, device, ramp, and its report back."""
PERSIST_S = 0.10
"""Reports that are wrong for this long are a fault."""
LONGEST_S = 0.02
"""Of the time between two reports no more counts: a site that stood still meanwhile reads what is long over."""
FORGIVEN = 0.5
"""A right report takes away this share of what a wrong one adds: an output that is wrong by turns is found, too."""
NEAR_N = 0.1
"""A force this near to what was asked for is right, N."""
UNREPORTED_FRAMES = 250
"""A CAN node that sends its place so often, 0.5 s, and no state meanwhile, hides what its outputs do."""


@dataclass(slots=True)
class Doubt:
    """Adds up for how long reports were wrong, as far as they were watched. Pure: times, s, in."""

    _wrong_s: float = 0.0
    _before_s: float | None = None
    """Between the last right report and the first wrong one, s: it may have begun at the end of it. None: no doubt."""
    _reported_s: float | None = None

    def step(self, t_s: float, wrong: bool) -> bool:
        """Take a report at its time; returns whether reports have been wrong for too long."""
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
    """Of an output that was not asked for."""
    _commanded: deque[tuple[float, int]] = field(default_factory=deque)
    _doubt: Doubt = field(default_factory=Doubt)

    def commanded(self, t_s: float, drive: int) -> None:
        """The device was sent a command; 0 is no output."""
        if self._commanded and self._commanded[-1][1] == drive:
            return  # it stays in force
        self._commanded.append((t_s, drive))
        _forget(self._commanded, t_s)  # a device that is away for hours reports nothing, and still gets commands

    def reported(self, t_s: float, drive: int) -> Fault | None:
        """The device reported what it applies; returns what is wrong with that, None when nothing is."""
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
    """Watches the force on each finger. A drive may be on its way from one command to another: the range counts.

    Pure: forces, N, and times, s, in.
    """

    def __init__(self) -> None:
        self._commanded: deque[tuple[float, Sequence[float]]] = deque()
        self._doubts = [Doubt() for _ in FINGERS]

    def commanded(self, t_s: float, force_n: Sequence[float]) -> None:
        """The device was sent forces, (5,), N."""
        commanded_n = tuple(force_n)
        if self._commanded and self._commanded[-1][1] == commanded_n:
            return  # they stay in force
        self._commanded.append((t_s, commanded_n))
        _forget(self._commanded, t_s)

    def reported(self, t_s: float, force_n: Sequence[float]) -> list[Fault]:
        """The device reported the forces that it applies, (5,), N; returns what is wrong with them."""
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
        """The lowest and the highest force in effect of one finger, N; looks no further than to one near `applied_n`.

        It is mostly near one of the newest.
        """
        low_n, high_n = math.inf, -math.inf
        for _, commanded_n in reversed(self._commanded):
            asked_n = commanded_n[index]
            low_n, high_n = min(low_n, asked_n), max(high_n, asked_n)
            if _near(applied_n, low_n, high_n):
                break
        return (low_n, high_n) if self._commanded else (0.0, 0.0)


@dataclass(slots=True)
class ReportMonitor:
    """Watches that a CAN node keeps reporting its outputs. It counts frames, not time: a line may be late."""

    _places: int = 0
    _states: int = 0
    _places_at_state: int = 0

    def step(self, places: int, states: int) -> None:
        """Take how many frames with its place, and how many state frames, have come in all."""
        self._places = places
        if states != self._states:
            self._states, self._places_at_state = states, places

    @property
    def fault(self) -> Fault | None:
        """What is wrong; None when nothing is."""
        missing = self._places - self._places_at_state > UNREPORTED_FRAMES
        return Fault(FaultCode.STATE_NOT_REPORTED) if missing else None


def _near(applied_n: float, low_n: float, high_n: float) -> bool:
    return low_n - NEAR_N <= applied_n <= high_n + NEAR_N


def _forget(commands: deque[tuple[float, int]] | deque[tuple[float, Sequence[float]]], t_s: float) -> None:
    while len(commands) > 1 and t_s - commands[1][0] > MEMORY_S:
        commands.popleft()
