"""An emergency stop of both sites: latched here at once, asked of the remote site until it answers, and its outcome."""

from dataclasses import dataclass, field

from common.faults.fault import Fault, FaultCode
from common.limits import AGE_MAX_S
from common.link.emergency_stop import PATIENCE_NS, EmergencyStop, Unconfirmed
from common.link.session_state import Session
from common.wire.packets import LinkState
from common.wire.session_messages import LONGEST_REFUSAL, Answer

REMOTE = "remote hand"
"""Name of all devices of the remote site as one device."""
_ANSWER_NS = PATIENCE_NS + round(2e9 * AGE_MAX_S)
"""Maximum time of the remote site's answer to an emergency stop on the slowest link, ns."""
_AGAIN_NS = 1_000_000_000
"""Time after which a remote site that could not confirm is asked again, ns."""


@dataclass(slots=True)
class SessionEmergencyStop:
    """Waits for this site's devices and the remote site to confirm. Pure: time is an argument, ns."""

    session: Session
    """Session that a stop latches; it notes the outcome."""
    _devices: EmergencyStop = field(default_factory=EmergencyStop)
    _now_ns: int = 0
    _began_ns: int = 0
    _answered_ns: int = 0
    _asking: bool = False
    """Whether the remote site must still be asked, because it has not answered."""
    _remote_s: float | None = None
    """Time from the stop to the remote site's confirmation, s; None without one."""
    _with_remote: bool = False
    _here: str = ""
    _there: str = ""

    @property
    def outcome(self) -> str:
        """Outcome of the last stop at both sites; empty while it is under way."""
        done = self._here and self._there
        return f"here: {self._here}; remote site: {self._there}" if done else ""

    @property
    def ask_remote(self) -> bool:
        """Whether to ask the remote site: it has not answered, or could not confirm a stop that is still latched."""
        late = self._with_remote and self._remote_s is None and self.asked_ns is not None
        return self._asking or (late and self._now_ns - self._answered_ns > _AGAIN_NS)

    @property
    def asked_ns(self) -> int | None:
        """Time of the latched stop, ns; None without one."""
        return self._devices.asked_ns

    @property
    def after_s(self) -> dict[str, float | None]:
        """Time until each device confirmed, s, with the remote site as REMOTE; None while one has not."""
        here = self._devices.after_s
        return {**here, REMOTE: self._remote_s} if self._with_remote and self.asked_ns is not None else here

    def begin(self, now_ns: int) -> None:
        """Latch this site; in a session, also ask the remote site."""
        self.session.latch(Fault(FaultCode.OPERATOR_STOP))
        self._devices.ask(now_ns)
        self._began_ns, self._asking = now_ns, bool(self.session.ident)
        self._with_remote, self._remote_s = self._asking, None
        self._here = ""
        self._there = "" if self._asking else "not connected"

    def step(self, now_ns: int, unconfirmed: Unconfirmed) -> None:
        """Check this site's devices, and note when the remote site has not answered in time."""
        self._now_ns = now_ns
        if self._devices.asked_ns is None and not self._asking:
            return
        confirmation = self._devices.step(now_ns, unconfirmed)
        if confirmation is not None:
            self._here = str(confirmation)
            self.session.note("estop", f"here: {confirmation}")
        if self._asking and not self._there and now_ns - self._began_ns > _ANSWER_NS:
            self._note_remote(f"not confirmed, no answer within {_ANSWER_NS * 1e-6:.0f} ms")
        if self.session.state is not LinkState.FAULT:
            self._devices.forget()

    def answered(self, answer: Answer) -> None:
        """Take the remote site's answer; an unasked one is ignored, and no refusal is noted twice."""
        if not self.ask_remote:
            return
        first, self._asking, self._answered_ns = self._asking, False, self._now_ns
        unconfirmed = answer.details.get("unconfirmed")
        after_s = answer.details.get("after_s")
        if answer.refused or not isinstance(after_s, float):
            outcome = f"not confirmed, {answer.refused or 'it does not say how it went'}"
        elif unconfirmed:
            outcome = f"not confirmed by {str(unconfirmed)[:LONGEST_REFUSAL]} after {after_s * 1e3:.0f} ms"
        else:
            self._remote_s = (self._now_ns - self._began_ns) * 1e-9
            outcome = f"stopped, confirmed by every device after {after_s * 1e3:.0f} ms"
        if first or self._remote_s is not None:
            self._note_remote(outcome)

    def remote_gone(self, why: str) -> None:
        """End the wait for the remote site, because the session is over."""
        if self._asking:
            self._asking = False
            self._note_remote(f"not confirmed, {why}")

    def _note_remote(self, outcome: str) -> None:
        self._there = outcome
        self.session.note("estop", f"remote site: {outcome}")
