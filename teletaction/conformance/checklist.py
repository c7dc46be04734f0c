"""Duties of firmware: a number, the words of docs/protocols.md, and the check that tries them on a device.

The words stand here and on that page; a test holds one against the other.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, Protocol, TypeVar

T = TypeVar("T")

TRIALS = 5
"""Of what is known to one report only: as often, at other phases."""
HALF_A_REPORT_S = 0.005
"""So much beyond a time limit passes: reports are stamped no better than to a few milliseconds by a gateway."""
PAUSE_S = 0.05
"""A host that was away for longer than this is no judge of what should have stayed in force."""
RATE_SHARE = 0.05
"""Of rates and clocks."""


class How(StrEnum):
    """What trying a duty takes, as the page and the command line have it."""

    LISTEN = "listening"
    EXERCISE = "--exercise"
    HEAT = "--heat"


class Verdict(StrEnum):
    """What became of a duty."""

    PASS = "pass"
    FAIL = "FAIL"
    NOT_APPLICABLE = "n/a"
    NOT_TRIED = "not tried"


@dataclass(frozen=True, slots=True)
class Came:
    """What a device did where something was demanded of it."""

    good: bool
    words: str


class NotApplicable(Exception):
    """A duty that this device, here and now, cannot be held to; says why."""


class Unsafe(Exception):
    """The device does more than was announced, or is another one: nothing is tried any further."""


@dataclass(frozen=True, slots=True)
class Duty(Generic[T]):
    """One demand of the page. The check may leave the outputs as they are: whoever calls it makes them neutral."""

    number: str
    demand: str
    how: How
    check: Callable[[T], Came]

    def tried_on(self, device: T) -> "Tried":
        """What becomes of it; raises Unsafe."""
        try:
            came = self.check(device)
        except NotApplicable as reason:
            return Tried(self, Verdict.NOT_APPLICABLE, str(reason))
        return Tried(self, Verdict.PASS if came.good else Verdict.FAIL, came.words)


class Checklist(Generic[T]):
    """The duties of one kind of device, in order.

    Attributes:
        title: heading on the page.
        duties: filled by `duty`.
    """

    def __init__(self, title: str) -> None:
        self.title = title
        self.duties: list[Duty[T]] = []

    def duty(
        self, number: str, demand: str, how: How = How.LISTEN
    ) -> Callable[[Callable[[T], Came]], Callable[[T], Came]]:
        """Put a check under its number and its demand."""

        def enter(check: Callable[[T], Came]) -> Callable[[T], Came]:
            self.duties.append(Duty(number, demand, how, check))
            return check

        return enter

    def table(self) -> str:
        """The rows as docs/protocols.md has them."""
        rows = [f"| {duty.number} | {duty.demand} | {duty.how} |" for duty in self.duties]
        return "\n".join([f"**{self.title}**", "", "| | duty | tried by |", "|---|---|---|", *rows])


@dataclass(frozen=True, slots=True)
class Tried:
    """A duty and what became of it."""

    duty: Duty[Any]
    verdict: Verdict
    came: str


class Driven(Protocol):
    """What can be made neutral."""

    def neutral(self) -> None:
        """Say that nothing is wanted."""

    def settle(self) -> None:
        """Neutral, and silence until the device is at rest."""


Trial = tuple[Duty[Any], Any]
"""A duty and the device that its check is given."""
