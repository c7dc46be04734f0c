"""The session with a virtual environment: nobody at the other end, and touch as soon as the hand is somewhere."""

from collections import Counter
from dataclasses import dataclass, field

from common.faults.fault import Fault, FaultCode
from common.limits import GAP_S
from common.link.clock_offset import ClockOffset
from common.link.emergency_stop import EmergencyStop, Unconfirmed
from common.link.packet_filter import PacketFilter
from common.link.session_state import Session
from common.wire.messages import MOTION_BLOCK, Motion, Touch
from common.wire.packets import Floats, LinkState
from operator_site.virtual.virtual_environment import VirtualEnvironment

_IDENT = 1
"""Number of the only session that there is."""


@dataclass(slots=True)
class VirtualSession:
    """Stands where `SessionClient` stands with a remote site. Time is an argument, ns of this site's monotonic clock.

    Touch is as fresh as the hand's place: where that is not known, nothing is touched.
    """

    environment: VirtualEnvironment
    name: str
    """Of what is touched, for people to read."""
    want_engaged: bool
    gap_s: float = GAP_S
    session: Session = field(default_factory=Session)
    acceptance: PacketFilter = field(default_factory=lambda: PacketFilter(max_age_ns=0))
    clock: ClockOffset = field(default_factory=ClockOffset)
    damaged: Counter[str] = field(default_factory=Counter)
    touch: Touch | None = None
    stopping: EmergencyStop = field(default_factory=EmergencyStop)
    stopped: str = ""
    """What came of the last emergency stop; empty while it is under way."""
    remote_fault: Fault | None = None
    remote_recording: str = ""
    refusal: str = ""
    calibrated: str = "Virtual: everything is as its scene says."
    spared: int = 0
    """Nothing is sent anywhere: there is nothing to spare."""
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
        """Engage when that is wished and possible, and see what came of an emergency stop.

        Args:
            now_ns: this site's clock.
            not_ready: why the site may not engage, such as a missing device; empty when it may.
            unconfirmed: why a device is not certain to have had its outputs off since a time, s.
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

    def send_motion(self, now_ns: int, block: Floats) -> bytes | None:
        """Touch with the fingertips at these places (5, 3), m; returns the packet that would tell a remote site."""
        ident, state = self.session.ident, self.session.state
        if not ident:
            return None
        self._sequence += 1
        (x_m, y_m, _), *_ = places = block.tolist()
        self.environment.step(now_ns * 1e-9, x_m, y_m, [z_m for _, _, z_m in places])
        self.touch = self.environment.packet(ident, self._sequence, now_ns, state)
        self.acceptance.accept(self.touch, ident, now_ns, offset_ns=0, uncertainty_ns=0)
        return Motion(ident, self._sequence, now_ns, state, MOTION_BLOCK.to_bytes(block)).encode()

    def stop(self, now_ns: int) -> None:
        """Emergency stop: latch at once."""
        self.want_engaged = False
        self.session.latch(Fault(FaultCode.OPERATOR_STOP))
        self.stopping.ask(now_ns)
        self.stopped = ""

    def disengage(self, now_ns: int, why: str = "") -> None:
        """Bring everything to neutral; engaging again is asked for anew."""
        self.want_engaged = False
        self.session.disengage(why)

    def clear(self, now_ns: int) -> None:
        """Clear the latched fault; raises Refused when there is none."""
        self.session.clear()

    def annotate(self, now_ns: int, text: str) -> None:
        """Note something for the recording."""
        self.session.note("note", text)

    def goodbye(self, now_ns: int) -> None:
        """Nobody is there to be told."""
