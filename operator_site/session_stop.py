"""An emergency stop of both sites: latched here at once, asked of the remote site until it answers, and its outcome."""

from collections.abc import Callable
from dataclasses import dataclass, field

from common.emergency_stop import PATIENCE_NS, EmergencyStop
from common.limits import AGE_MAX_S
from common.session import Session
from common.session_messages import LONGEST_REFUSAL, Answer

_ANSWER_NS = PATIENCE_NS + round(2e9 * AGE_MAX_S)
"""On the slowest link the remote site's word of an emergency stop takes as long."""


@dataclass(slots=True)
class SessionStop:
    """Waits for this site's devices and for the remote site. Pure: time is an argument, ns of this site's clock."""

    session: Session
    """Is latched by a stop, and what comes of it is noted there."""
    ask_remote: bool = False
    """The remote site has not answered: it is to be asked, again and again."""
    _devices: EmergencyStop = field(default_factory=EmergencyStop)
    _began_ns: int = 0
    _here: str = ""
    _there: str = ""

    @property
    def outcome(self) -> str:
        """What came of the last stop, at this site and at the remote one; empty while it is under way."""
        done = self._here and self._there
        return f"here: {self._here}; remote site: {self._there}" if done else ""

    def begin(self, now_ns: int, why: str) -> None:
        """Latch this site; without a session there is nobody else to ask."""
        self.session.latch(why)
        self._devices.ask(now_ns)
        self._began_ns, self.ask_remote = now_ns, bool(self.session.ident)
        self._here = ""
        self._there = "" if self.ask_remote else "not connected"

    def step(self, now_ns: int, unconfirmed: Callable[[float], str]) -> None:
        """Take what this site's devices say, and note when the remote site has let its time pass.

        Args:
            now_ns: this site's clock.
            unconfirmed: which devices have not reported since a time (s) that their outputs are off.
        """
        confirmation = self._devices.step(now_ns, unconfirmed)
        if confirmation is not None:
            self._here = str(confirmation)
            self.session.note("estop", f"here: {confirmation}")
        if self.ask_remote and not self._there and now_ns - self._began_ns > _ANSWER_NS:
            self._note_remote(f"not confirmed, no answer within {_ANSWER_NS * 1e-6:.0f} ms")

    def answered(self, answer: Answer) -> None:
        """Take the remote site's word; what it says again, or was not asked for, counts for nothing."""
        if not self.ask_remote:
            return
        self.ask_remote = False
        told = answer.details.get("unconfirmed")
        after_s = answer.details.get("after_s")
        if answer.refused or not isinstance(after_s, float):
            self._note_remote(f"not confirmed, {answer.refused or 'it does not say how it went'}")
        elif told:
            self._note_remote(f"not confirmed by {str(told)[:LONGEST_REFUSAL]} after {after_s * 1e3:.0f} ms")
        else:
            self._note_remote(f"stopped, confirmed by every device after {after_s * 1e3:.0f} ms")

    def remote_gone(self, why: str) -> None:
        """The session is over: whoever has not answered by now never will."""
        if self.ask_remote:
            self.ask_remote = False
            self._note_remote(f"not confirmed, {why}")

    def _note_remote(self, outcome: str) -> None:
        self._there = outcome
        self.session.note("estop", f"remote site: {outcome}")
