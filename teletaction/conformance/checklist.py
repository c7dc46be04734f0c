"""Define duties of firmware: a number, the text of docs/protocols.md, and the check that tests a device.

The text is both here and on that page; a test compares the two.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, Protocol, TypeVar

T = TypeVar("T")

TRIALS = 5
"""Number of trials of a time that is measured with a resolution of one report; each has another phase."""
HALF_A_REPORT_S = 0.005
"""Tolerance on a time limit, s; a gateway's time stamps are accurate to a few milliseconds only."""
PAUSE_S = 0.05
"""Longest pause of the host, s, after which it can still judge that a command stayed in force."""
RATE_SHARE = 0.05
"""Relative tolerance of rates and clocks."""
STOPPED_S = 0.5
"""Shortest time without reports, at the start or end of listening, that counts as missing, s; a host may pause."""


class How(StrEnum):
    """Kind of trial that a duty needs, as named on the page and the command line."""

    LISTEN = "listening"
    EXERCISE = "--exercise"
    HEAT = "--heat"


class Verdict(StrEnum):
    """Result of a duty."""

    PASS = "pass"
    FAIL = "FAIL"
    NOT_APPLICABLE = "n/a"
    NOT_TRIED = "not tried"


@dataclass(frozen=True, slots=True)
class Outcome:
    """Outcome of a check: whether the device met the demand, and what it did."""

    good: bool
    words: str


def all_good(outcomes: Iterable[Outcome], words: str) -> Outcome:
    """Return the first bad outcome, after which nothing more is tried; if all are good, a good one with these words."""
    return next((outcome for outcome in outcomes if not outcome.good), Outcome(True, words))


class NotApplicable(Exception):
    """The duty cannot be tested on this device at present; the text gives the reason."""


class Unsafe(Exception):
    """The device exceeds the announced limits or is another device; all trials stop."""


@dataclass(frozen=True, slots=True)
class Duty(Generic[T]):
    """One demand of the page. The check may leave outputs active; its caller makes them neutral."""

    number: str
    demand: str
    how: How
    check: Callable[[T], Outcome]

    def tried_on(self, device: T) -> "Tried":
        """Test the device and return the result; raise Unsafe if a check does."""
        try:
            outcome = self.check(device)
        except NotApplicable as reason:
            return Tried(self, Verdict.NOT_APPLICABLE, str(reason))
        return Tried(self, Verdict.PASS if outcome.good else Verdict.FAIL, outcome.words)


class Checklist(Generic[T]):
    """The duties of one kind of device, in order.

    Attributes:
        title: heading on the page.
        duties: the duties added by `duty`.
    """

    def __init__(self, title: str) -> None:
        self.title = title
        self.duties: list[Duty[T]] = []

    def duty(
        self, number: str, demand: str, how: How = How.LISTEN
    ) -> Callable[[Callable[[T], Outcome]], Callable[[T], Outcome]]:
        """Return a decorator that adds a check with its number and demand."""

        def enter(check: Callable[[T], Outcome]) -> Callable[[T], Outcome]:
            self.duties.append(Duty(number, demand, how, check))
            return check

        return enter

    def table(self) -> str:
        """Return the table as in docs/protocols.md."""
        rows = [f"| {duty.number} | {duty.demand} | {duty.how} |" for duty in self.duties]
        return "\n".join([f"**{self.title}**", "", "| | duty | tried by |", "|---|---|---|", *rows])


@dataclass(frozen=True, slots=True)
class Tried:
    """A duty and its result."""

    duty: Duty[Any]
    verdict: Verdict
    came: str


class Driven(Protocol):
    """A device that can be made neutral."""

    def settle(self, longer_s: float = 0.0) -> None:
        """Command neutral outputs, then send nothing until the device is at rest, and for `longer_s` more."""


def phases(device: Driven) -> Iterator[None]:
    """Yield once for each trial, with the device at rest; other phases resolve a time between two reports."""
    for trial in range(TRIALS):
        device.settle(0.002 * trial)
        yield


def acting_s(reports: Iterable[tuple[float, bool]]) -> float:
    """Return the time from the first to the last report of an action, s, 0 without one.

    Args:
        reports: times, s, and whether the action is reported.
    """
    times_s = [at_s for at_s, acts in reports if acts]
    return times_s[-1] - times_s[0] if times_s else 0.0


def span_s(times_s: Sequence[float], what: str = "reports") -> float:
    """Return the time from the first to the last report or frame, s.

    Raises:
        NotApplicable: there are fewer than two, or all came at once.
    """
    if len(times_s) < 2 or times_s[-1] <= times_s[0]:
        raise NotApplicable(f"no {what}" if len(times_s) < 2 else f"all {what} came at once")
    return times_s[-1] - times_s[0]


def require_punctual(away_s: float) -> None:
    """Raise NotApplicable if this host paused between two commands until one may have timed out."""
    if away_s > PAUSE_S:
        raise NotApplicable(f"this host paused for {1e3 * away_s:.0f} ms during the trial: try again")


Trial = tuple[Duty[Any], Any]
"""A duty and the device that its check tests."""
