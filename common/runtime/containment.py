"""Contains an exception inside a step of a site's tick: it gets a name and latches a fault, and the process continues.

Every `Exception` is contained, MemoryError and RecursionError among them: a process that continues with neutral outputs
and a latched fault is safer than one that ends. KeyboardInterrupt and SystemExit pass. A gate contains nothing itself:
where a gate raises, the site's tick writes a fixed neutral output in its place.
"""

import logging
import os
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from common.faults.fault import LONGEST_DETAIL, Fault, contained
from common.files.printable import one_line
from common.link.session_state import Refused
from common.wire.packets import BadPacket

log = logging.getLogger(__name__)

NAMED_IN = "TELETACTION_CONTAINED"
"""Environment variable: a file that gets one line for each contained exception that is logged. Tests read it."""
MOST_PLACES = 64
"""Places that are counted apart; exceptions of further places count as OTHERS."""
OTHERS = "others"
_CALLERS = 6
"""Callers that the log names."""


class Containment:
    """Runs steps of one process and contains what they raise.

    Attributes:
        count: exceptions contained so far.
        places: how many of them each place raised; a place is step, exception, file, line and function.
        latest: name of the newest exception of each step, with its message.
    """

    def __init__(self, latch: Callable[[Fault], None] = lambda fault: None):
        """Latch faults by `latch`."""
        self.count = 0
        self.places: Counter[str] = Counter()
        self.latest: dict[str, str] = {}
        self._latch = latch
        self._named: set[str] = set()
        self._latched = False
        self._steps: dict[tuple[str, bool, tuple[type[Exception], ...]], Step] = {}

    def step(self, name: str, *, latches: bool = True, passes: tuple[type[Exception], ...] = ()) -> "Step":
        """A context that contains what is raised in it, except `passes`; with `latches` each one latches a fault."""
        which = (name, latches, passes)
        if which not in self._steps:
            self._steps[which] = Step(self, name, latches, passes)
        return self._steps[which]

    def request(self, name: str) -> "_Request":
        """A context that turns what a peer's request raises into its refusal: others are served, nothing is latched.

        Raises:
            Refused: the request raised something else than Refused or BadPacket, which pass.
        """
        return _Request(self, name)

    def caught(self, step: str, error: Exception, *, latches: bool) -> str:
        """Count and log an exception, and latch a fault if it `latches`; returns its name."""
        frames = _frames(error.__traceback__)
        place = f"{step}: {type(error).__name__} in {frames[-1] if frames else 'nothing of ours'}"
        name = self.latest[step] = one_line(f"{place}: {_message(error)}", LONGEST_DETAIL)
        if place not in self.places and len(self.places) >= MOST_PLACES:
            place = OTHERS
        self.count += 1
        self.places[place] += 1
        if place not in self._named:
            self._named.add(place)
            _note(name, frames)
        if latches:
            self._latched = True
            self._latch(contained(name))
        return name

    def not_latched(self) -> None:
        """No fault is latched in this tick. Where one of these was, a person cleared it: each place is logged anew."""
        if self._latched:
            self._latched = False
            self._named.clear()


class Step:
    """What `Containment.step` returns."""

    __slots__ = ("_containment", "_latches", "_name", "_passes")

    def __init__(self, containment: Containment, name: str, latches: bool, passes: tuple[type[Exception], ...]):
        self._containment, self._name, self._latches, self._passes = containment, name, latches, passes

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        if not isinstance(error, Exception) or isinstance(error, self._passes):
            return False
        self._containment.caught(self._name, error, latches=self._latches)
        return True


class _Request:
    """What `Containment.request` returns."""

    __slots__ = ("_containment", "_name")

    def __init__(self, containment: Containment, name: str):
        self._containment, self._name = containment, name

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, Exception) and not isinstance(error, (Refused, BadPacket)):
            name = self._containment.caught(self._name, error, latches=False)
            raise Refused(f"this site failed at the request: {name}") from None


MakeContainment = Callable[[Callable[[Fault], None]], Containment]


def _frames(trace: TracebackType | None) -> list[str]:
    """Where an exception passed, its origin last: file, line and function; no source file is read for it."""
    found = []
    while trace is not None:
        code = trace.tb_frame.f_code
        found.append(f"{os.path.basename(code.co_filename)}:{trace.tb_lineno} {code.co_name}")
        trace = trace.tb_next
    return found


def _message(error: Exception) -> str:
    try:
        return str(error)
    except Exception:  # an exception that cannot be shown is still named by its type
        return "no message"


def _note(name: str, frames: list[str]) -> None:
    """Log an exception, and append it to the file that NAMED_IN names."""
    log.error("contained: %s; called by %s", name, " < ".join(reversed(frames[-_CALLERS - 1 : -1])) or "nothing")
    if path := os.environ.get(NAMED_IN):
        with suppress(OSError), Path(path).open("a", encoding="utf-8") as file:
            file.write(f"{name}\n")
