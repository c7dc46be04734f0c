"""Runs the session with a virtual environment, without a remote site."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from common.faults.fault import Fault, FaultCode
from common.limits import GAP_S
from common.link.clock_offset import ClockOffset
from common.link.emergency_stop import EmergencyStop, Unconfirmed
from common.link.packet_filter import PacketFilter
from common.link.session_state import Session
from common.wire.messages import Touch, motion_packet, motion_rows, pack_hand
from common.wire.noted_consent import NotedConsent
from common.wire.packets import LinkState
from operator_site.session.remote_status import RemotePatient
from operator_site.virtual.virtual_environment import VirtualEnvironment

_IDENT = 1
"""Number of the only session."""


@dataclass(slots=True)
class VirtualSession:
    """Replaces `SessionClient`. Time is an argument, ns of this site's monotonic clock.

    A touch is computed from each known position of the hand. Without a position there is no touch.
    """

    environment: VirtualEnvironment
    name: str
    """Readable name of the environment."""
    want_engaged: bool
    gap_s: float = GAP_S
    engages_itself: bool = False
    session: Session = field(default_factory=Session)
    acceptance: PacketFilter = field(default_factory=lambda: PacketFilter(max_age_ns=0))
    clock: ClockOffset = field(default_factory=ClockOffset)
    damaged: Counter[str] = field(default_factory=Counter)
    touch: Touch | None = None
    stopping: EmergencyStop = field(default_factory=EmergencyStop)
    stopped: str = ""
    """Result of the last emergency stop; empty while it is under way."""
    remote_fault: Fault | None = None
    remote_recording: str = ""
    remote_stale: str = ""
    remote_patient: RemotePatient | None = None
    patient_ns: int = 0
    refusal: str = ""
    calibrated: str = "Virtual: everything is as its scene says."
    roughness_um: dict[str, float] | None = None
    remote_consent: NotedConsent | None = None
    spared: int = 0
    """Number of motion packets that were not sent because of no perceptible change; always 0."""
    _sequence: int = 0

    @property
    def both_engaged(self) -> bool:
        """Whether outputs may act."""
        return self.session.engaged and self.touch is not None

    @property
    def touch_packet(self) -> bytes:
        """The newest touch as a remote site would have sent it."""
        return b"" if self.touch is None else self.touch.encode()

    def step(self, now_ns: int, not_ready: str, unconfirmed: Unconfirmed) -> None:
        """Engage unless a reason `not_ready` is given, and check the confirmation of an emergency stop.

        `unconfirmed` returns why each device may have had outputs on since a time, s.
        """
        session = self.session
        if not session.ident:
            session.connect(_IDENT, self.name)
        session.heard(self.acceptance.gap_ns(now_ns), self.gap_s, "motion")
        confirmation = self.stopping.step(now_ns, unconfirmed)
        if confirmation is not None:
            self.stopped = str(confirmation)
            session.note("estop", self.stopped)
        if session.state is LinkState.FAULT:
            self.want_engaged = False
            return
        self.stopping.forget()
        if self.want_engaged and not session.engaged and not not_ready:
            session.engage()

    def send_motion(self, now_ns: int, x_m: float, y_m: float, z_m: Sequence[float]) -> bytes | None:
        """Touch with the hand at this place and the fingertips at these heights (5,), m; return the motion packet."""
        ident, state = self.session.ident, self.session.state
        if not ident:
            return None
        self._sequence += 1
        floats = pack_hand(x_m, y_m, z_m)
        rows = motion_rows(floats)
        self.environment.step(now_ns * 1e-9, rows[0].x_m, rows[0].y_m, [row.z_m for row in rows])
        self.touch = self.environment.packet(ident, self._sequence, now_ns, state)
        self.acceptance.accept(self.touch, ident, now_ns, offset_ns=0, uncertainty_ns=0)
        return motion_packet(ident, self._sequence, now_ns, state, floats)

    def engage(self) -> None:
        """Request engaging for a person."""
        self.want_engaged = True

    def stop(self, now_ns: int) -> None:
        """Latch an emergency stop at once."""
        self.want_engaged = False
        self.session.latch(Fault(FaultCode.OPERATOR_STOP))
        self.stopping.ask(now_ns)
        self.stopped = ""

    def disengage(self, now_ns: int, why: str = "") -> None:
        """Bring all outputs to neutral; engaging needs a new request."""
        self.want_engaged = False
        self.session.disengage(why)

    def clear(self, now_ns: int) -> None:
        """Clear the latched fault; raise Refused without one. Engaging needs a new request."""
        self.session.clear()
        self.want_engaged = False

    def annotate(self, now_ns: int, text: str) -> None:
        """Record a note."""
        self.session.note("note", text)

    def goodbye(self, now_ns: int) -> None:
        """Do nothing, because there is no peer."""
