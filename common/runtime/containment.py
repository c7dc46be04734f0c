"""Contains an exception inside a step of a site's tick: the exception latches a fault, and the process continues.

Every `Exception` is contained, MemoryError and RecursionError among them: a process that continues with neutral outputs
and a latched fault is safer than one that ends. KeyboardInterrupt and SystemExit pass. A gate contains nothing itself:
where a gate raises, the site's tick writes a fixed neutral output in its place.
"""

import logging
import os
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType

from common.faults.fault import LONGEST_DETAIL, Fault, contained
from common.files.printable import one_line
from common.link.session_state import Refused
from common.wire.packets import BadPacket

log = logging.getLogger(__name__)

NAMED_IN = "TELETACTION_CONTAINED"
"""Environment variable with the name of a file that gets one line for each logged exception. Tests read it."""
MOST_PLACES = 64
"""Maximum number of places with a count of their own; exceptions of further places count as OTHERS."""
OTHERS = "others"
_CALLERS = 6
"""Maximum number of callers in a log line."""


class Containment:
    """Runs steps of one process and contains what they raise.

    Attributes:
        count: number of contained exceptions.
        places: number of exceptions of each place; a place is step, exception, file, line and function.
        latest: name of the newest exception of each step, with its message.
    """

    def __init__(self, latch: Callable[[Fault], None] = lambda fault: None):
        self.count = 0
        self.places: Counter[str] = Counter()
        self.latest: dict[str, str] = {}
        self._latch = latch
        self._named: set[str] = set()
        self._latched = False
        self._steps: dict[tuple[str, bool, tuple[type[Exception], ...]], Step] = {}

    def step(self, name: str, *, latches: bool = True, passes: tuple[type[Exception], ...] = ()) -> "Step":
        """Return a context that contains exceptions except `passes`; with `latches` each one latches a fault."""
        which = (name, latches, passes)
        if which not in self._steps:
            self._steps[which] = Step(self, name, latches, passes)
        return self._steps[which]

    @contextmanager
    def request(self, name: str) -> Iterator[None]:
        """Contain a peer's request: Refused and BadPacket pass, any other exception becomes Refused; latch nothing.

        Raises:
            Refused: the request raised another exception.
        """
        try:
            yield
        except (Refused, BadPacket):
            raise
        except Exception as error:
            caught = self.caught(name, error, latches=False)
            raise Refused(f"this site failed at the request: {caught}") from None

    def caught(self, step: str, error: Exception, *, latches: bool) -> str:
        """Count and log an exception, and latch a fault with `latches`; return the exception's name."""
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
        """Note that no fault is latched in this tick. After a person has cleared one, each place is logged again."""
        if self._latched:
            self._latched = False
            self._named.clear()


class Step:
    """Context of `Containment.step`."""

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


MakeContainment = Callable[[Callable[[Fault], None]], Containment]


def _frames(trace: TracebackType | None) -> list[str]:
    """Return file, line and function of each frame of an exception, its origin last, without reading source files."""
    found = []
    while trace is not None:
        code = trace.tb_frame.f_code
        found.append(f"{os.path.basename(code.co_filename)}:{trace.tb_lineno} {code.co_name}")
        trace = trace.tb_next
    return found


def _message(error: Exception) -> str:
    try:
        return str(error)
    except Exception:  # the name still has the type of an exception without a printable message
        return "no message"


def _note(name: str, frames: list[str]) -> None:
    """Log an exception, and append it to the file that NAMED_IN names."""
    log.error("contained: %s; called by %s", name, " < ".join(reversed(frames[-_CALLERS - 1 : -1])) or "nothing")
    if path := os.environ.get(NAMED_IN):
        with suppress(OSError), Path(path).open("a", encoding="utf-8") as file:
            file.write(f"{name}\n")
