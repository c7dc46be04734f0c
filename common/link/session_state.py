"""Keeps the state of a session, alike on both sites: disconnected, connected, engaged, or fault (latched)."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field

from common.faults.fault import OF_THE_PATIENT, PERSONS_STOPS, Fault, FaultCode, replaces
from common.faults.texts import fault_text
from common.files.printable import printable, printable_lines
from common.recording.recorded_row import Row, Whole
from common.wire.packets import LinkState

log = logging.getLogger(__name__)


_SERIOUS = ("fault", "estop", "silent", "missing")
"""Happenings that are logged as warnings."""


class Refused(ValueError):
    """A request that the present state does not allow; the message says why and what to do."""


LONGEST_NOTE = 1000
"""Maximum length of a note for the recording, characters."""


def note_text(details: Mapping[str, object]) -> str:
    """Return the text of a note from its request's details, as lines of printable characters.

    Raises:
        Refused: there is no text, or it is too long.
    """
    text = details.get("text")
    if not isinstance(text, str) or not 0 < len(text) <= LONGEST_NOTE:
        raise Refused(f"a note needs a text of 1 to {LONGEST_NOTE} characters")
    return printable_lines(text)


class Happening(Row):
    """A change of a session: its number (0 for none), a text such as the far side's capabilities, or a fault."""

    what: str
    """connected, left, disconnected, engaged, disengaged, fault, cleared, estop, silent, heard, missing, complete,
    clutch, scale; where no remote site takes notes, note."""
    session: Whole
    text: str
    fault: Fault | None
    """The fault that was latched or cleared."""


@dataclass(slots=True)
class Session:
    """One site's session state. Outputs are possible in ENGAGED only; a fault latches."""

    state: LinkState = LinkState.DISCONNECTED
    ident: int = 0
    """Number of the session, chosen by the remote site at hello; 0 while there is none."""
    fault: Fault | None = None
    """The latched fault; None without one."""
    paused: str | None = None
    """Reason why the session was disengaged, empty if a person at this site asked for it; None while it was not."""
    cleared_here_only: bool = False
    """Whether a person at this site or the patient latched the fault; then only a person at this site may clear it."""
    stop: FaultCode | None = None
    """The stop that a person has requested since the last clearing, also where another fault was latched before it; of
    several the last one in PERSONS_STOPS."""
    silent: bool = False
    """Whether the far side's stream fell silent while engaged, and is still silent."""
    _happened: list[Happening] = field(default_factory=list)
    _missing: str = ""

    @property
    def engaged(self) -> bool:
        """Whether outputs may leave neutral."""
        return self.state is LinkState.ENGAGED

    def connect(self, ident: int, text: str = "") -> None:
        """Begin a new session after the far side's hello, not engaged. A latched fault remains.

        Raises:
            ValueError: the session's number is not positive.
        """
        if ident <= 0:
            raise ValueError(f"session number {ident} is not positive")
        self.ident = ident
        if self.state is not LinkState.FAULT:
            self.state = LinkState.CONNECTED
        self.paused = None
        self._missing = ""
        self.note("connected", text)

    def disconnect(self, why: str = "", *, left: bool = False) -> None:
        """End the session; `left` if the far side left on purpose, and `why` for people to read.

        A latched fault remains; a far side may connect again to clear it.
        """
        if self.ident:
            self.note("left" if left else "disconnected", why)
        self.ident = 0
        if self.state is not LinkState.FAULT:
            self.state = LinkState.DISCONNECTED

    def engage(self, text: str = "") -> None:
        """Let outputs leave neutral; raises Refused where there is no far side, or a fault is latched."""
        if self.state is LinkState.FAULT:
            raise Refused(f"a fault is latched ({fault_text(self.fault)}): clear it first")
        if self.state is LinkState.DISCONNECTED:
            raise Refused("no far side is connected: say hello first")
        if self.state is not LinkState.ENGAGED:
            self.note("engaged", text)
        self.state = LinkState.ENGAGED
        self.paused = None

    def disengage(self, why: str = "") -> None:
        """Bring outputs to neutral; always allowed. `why` is empty if a person at this site asks for it."""
        if self.state is LinkState.ENGAGED:
            self.state = LinkState.CONNECTED
            self.paused = printable(why)
            self.note("disengaged", why)

    def latch(self, fault: Fault, *, cleared_here_only: bool = False) -> None:
        """Latch a fault: outputs stay neutral until a person clears it.

        The first fault is kept, but the patient's stop takes the place of any other fault.

        Args:
            fault: the fault.
            cleared_here_only: whether a person at this site latched it; then the far side must not clear it.
        """
        if fault.code in PERSONS_STOPS and (self.stop is None or _later(fault.code, self.stop)):
            self.stop = fault.code
        self.cleared_here_only = self.cleared_here_only or cleared_here_only or fault.code in OF_THE_PATIENT
        if self.fault is None or replaces(fault.code, self.fault.code):
            self.fault = fault.bounded()
            self.state = LinkState.FAULT
            self.note("fault", fault=self.fault)

    def clear(self, *, here: bool = True) -> None:
        """Clear a latched fault. Outputs stay neutral until the session is engaged again.

        Args:
            here: whether a person at this site clears it.

        Raises:
            Refused: no fault is latched, or only this site may clear it and the far side asks.
        """
        if self.state is not LinkState.FAULT:
            raise Refused("no fault is latched")
        if self.cleared_here_only and not here:
            raise Refused(f"{fault_text(self.fault)}: to be cleared where it was latched")
        self.note("cleared", fault=self.fault)
        self.fault = self.stop = None
        self.cleared_here_only = False
        self.state = LinkState.CONNECTED if self.ident else LinkState.DISCONNECTED

    def heard(self, gap_ns: int | None, gap_s: float, stream: str) -> None:
        """Note when a stream falls silent while engaged, and when it is heard again.

        Its last accepted packet came `gap_ns` ago, None before the first; a gap of `gap_s`, s, causes the safe state.
        """
        silent = gap_ns is None or not 0 <= gap_ns <= gap_s * 1e9
        if silent and not self.silent and self.engaged and gap_ns is not None:
            self.silent = True
            self.note("silent", f"no {stream} for {gap_s * 1e3:.0f} ms")
        elif self.silent and not silent:
            self.silent = False
            self.note("heard", f"{stream} again")

    def equipped(self, missing: str) -> None:
        """Note when a device is missing in a session, and when no device is missing any more."""
        if self.ident and missing != self._missing:
            self.note("missing" if missing else "complete", missing)
            self._missing = missing

    def note(self, what: str, text: str = "", fault: Fault | None = None) -> None:
        """Log a happening and keep it for the recording, its text as one printable line; a note keeps its lines."""
        level = logging.WARNING if what in _SERIOUS else logging.INFO
        said = printable_lines(text) if what == "note" else printable(text)
        shown = said or fault_text(fault)
        log.log(level, "%s%s", what, f": {shown}" if shown else "", extra={"happening": what})
        self._happened.append(Happening(what, self.ident, said, fault))

    def take_happenings(self) -> list[Happening]:
        """Return the happenings since the last call."""
        happened, self._happened = self._happened, []
        return happened


def _later(code: FaultCode, other: FaultCode) -> bool:
    """Return whether a stop takes the place of another."""
    return PERSONS_STOPS.index(code) > PERSONS_STOPS.index(other)
