"""The operator site's end of the session: hello, clock comparison, engaging, motion out and touch in."""

import logging
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from common.faults.fault import Fault, read_fault
from common.limits import AGE_MAX_S, GAP_S
from common.link.capabilities import OBSERVER, OPERATOR, disagreement, misreading
from common.link.clock_offset import ClockOffset, ReadClock
from common.link.deadband import Deadband, DeadReckoning, motion_perceptible
from common.link.emergency_stop import Unconfirmed
from common.link.link_sides import OperatorSide
from common.link.packet_filter import PacketFilter
from common.link.rate_limiter import RateLimiters
from common.link.session_state import Session
from common.timing.timeouts import MOTION_SILENCE_S, SECOND_REFRESH_S, SESSION_SILENCE_S
from common.wire.messages import Touch, motion_packet, motion_rows, pack_hand
from common.wire.noted_consent import NotedConsent
from common.wire.packets import BadPacket, LinkState, WrongVersion
from common.wire.roughness_um import RoughnessUm
from common.wire.session_messages import ASKED_BEFORE, Answer, Heartbeat, Request
from common.wire.streams import STREAMS
from operator_site.session.emergency_stop import SessionEmergencyStop
from operator_site.session.growing_wait import GrowingWait
from operator_site.session.remote_status import RemotePatient, late_motion, recording_stopped, remote_patient
from operator_site.session.second_connections import SecondConnections

log = logging.getLogger(__name__)

NO_MOTION = "no motion reaches the remote site; check that its port link.base_port is open"
SILENCE_NS = round(SESSION_SILENCE_S * 1e9)
"""Time without an answer to heartbeats after which the remote site counts as gone, ns; then hello is sent again."""
LONGEST_DESCRIPTION = 80
"""Maximum length of the remote site's description of its calibration, characters."""
_ASK_NS = 200_000_000
"""Time between two tries of a request, ns."""
_STATUS_NS = 1_000_000_000
"""Time between two requests for the status of a remote site without a fault, ns."""
_OFTEN_NS = 200_000_000
"""The same where the remote site has a pain slider, or gets no motion, ns."""
_OBJECTED_S = 1.0, 30.0
"""First and longest wait before hello to a remote site that this site has refused, s."""
_UNMOVED_S = 5.0, 60.0
"""First and longest wait before engaging again where no motion reached the remote site, s."""
_MOVED_NS = round(1.5e9 * MOTION_SILENCE_S)
"""Time for which the sites stay engaged only if motion arrives, ns."""
_BEAT_NS = round(1e9 / STREAMS["heartbeat"].rate_hz)
_LONG_AGO_NS = -(10**18)
_PACKETS_PER_S, _PACKETS_AT_ONCE = 100.0, 200
"""Maximum rate, 1/s, and burst of the remote site's answers, or heartbeats; it sends 20 heartbeats a second."""


@dataclass(slots=True)
class SessionClient:
    """Keeps a session with the remote site, and starts a new one when it is lost. Time is an argument, ns.

    An observer receives the same touch packets on a separate stream, and requests nothing but the session.
    """

    link: OperatorSide
    capabilities: dict[str, Any]
    max_age_s: float
    want_engaged: bool
    """Whether to request engaging until both sites are engaged; a fault of either clears it."""
    engages_itself: bool = True
    """Whether `want_engaged` survives the end and the begin of a session, and a remote site that disengages; where a
    person engages, a person must engage again."""
    calibration: str = ""
    """Required hash of the remote site's calibration; empty for any."""
    role: str = OPERATOR
    gap_s: float = GAP_S
    stamp_ns: ReadClock | None = None
    deadband: Deadband | None = None
    """Omits motion without a perceptible change; without it, every call sends."""
    session: Session = field(default_factory=Session)
    clock: ClockOffset = field(default_factory=ClockOffset)
    touch: Touch | None = None
    """The newest accepted touch of this session."""
    touch_packet: bytes = b""
    """Received bytes of `touch`."""
    remote: dict[str, Any] = field(default_factory=dict)
    """Capabilities of the remote site, from its answer to hello."""
    remote_fault: Fault | None = None
    """The fault latched at the remote site; None without one."""
    remote_recording: str = ""
    """Reason why the remote site's recording stopped; empty while it works or if unknown."""
    _late_motion: str = ""
    remote_patient: RemotePatient | None = None
    """What the remote site last reported of its patient; None without a pain slider."""
    patient_ns: int = 0
    """Time of that report, ns."""
    acceptance: PacketFilter = field(init=False)
    stopping: SessionEmergencyStop = field(init=False)
    damaged: Counter[str] = field(default_factory=Counter)
    refusal: str = ""
    """Reason why the remote site refused the last hello, engage or clear_fault, or ended the last session, or why this
    site refuses the remote one; empty without any."""
    _ended: str = ""
    """Reason why the remote site ended the last session; empty once this one is engaged."""
    _sequence: int = 0
    """Number of the last request or heartbeat; it continues across sessions, so that an old answer is recognized."""
    _motion_sequence: int = 0
    """Number of the last motion. Only this side knows where a session's numbers begin, which is its authority."""
    _expected: DeadReckoning = field(default_factory=DeadReckoning)
    """The remote site's estimate of the hand, as if no packet were lost."""
    _sent_state: LinkState = LinkState.DISCONNECTED
    _now_ns: int = _LONG_AGO_NS
    _asked_ns: dict[str, int] = field(default_factory=dict)
    _asked: dict[int, str] = field(default_factory=dict)
    _wanted_ns: int = 0
    """Time of a person's request to engage that waits; of the last step without one, ns."""
    _rates: RateLimiters[str] = field(default_factory=lambda: RateLimiters(_PACKETS_PER_S, _PACKETS_AT_ONCE))
    _beat_ns: int = _LONG_AGO_NS
    _heard_ns: int = 0
    _engaged_ns: int = 0
    _second: SecondConnections = field(default_factory=SecondConnections)
    _objected: GrowingWait = field(default_factory=lambda: GrowingWait(*_OBJECTED_S))
    _unmoved: GrowingWait = field(default_factory=lambda: GrowingWait(*_UNMOVED_S))

    def __post_init__(self) -> None:
        self.stopping = SessionEmergencyStop(self.session)
        self.acceptance = PacketFilter(max_age_ns=round(self.max_age_s * 1e9))

    @property
    def both_engaged(self) -> bool:
        """Whether both sites say that outputs may act."""
        touch = self.touch
        return touch is not None and self.session.state is touch.state is LinkState.ENGAGED

    @property
    def stopped(self) -> str:
        """Outcome of the last emergency stop at both sites; empty while it is under way."""
        return self.stopping.outcome

    @property
    def remote_stale(self) -> str:
        """Since when no motion arrives at the remote site, while this site is engaged; empty otherwise."""
        return self._late_motion if self.session.engaged else ""

    @property
    def calibrated(self) -> str:
        """The remote site's description of its calibration; empty if unknown."""
        return str(self.remote.get("calibrated", ""))[:LONGEST_DESCRIPTION]

    @property
    def remote_consent(self) -> NotedConsent | None:
        """What the remote site has noted of the patient's consent; None before its first answer to hello."""
        return NotedConsent.of(self.remote) if self.remote else None

    @property
    def roughness_um(self) -> dict[str, float] | None:
        """The remote site's scale of roughness in um; None if it sent none."""
        scale = RoughnessUm.of(self.remote.get("roughness_um"))
        return None if scale is None else scale._asdict()

    @property
    def spared(self) -> int:
        """Number of motions omitted because no change was perceptible."""
        return 0 if self.deadband is None else self.deadband.spared

    def step(self, now_ns: int, not_ready: str, unconfirmed: Unconfirmed = lambda _: {}) -> None:
        """Take the received packets, and send heartbeats and due requests.

        Args:
            now_ns: this site's clock, ns.
            not_ready: reason why the site may not engage, such as a missing device; empty when it may.
            unconfirmed: returns for each device why its outputs may not be off since a time, s.
        """
        if now_ns < self._now_ns:  # the clock was set back: earlier times are invalid
            self._asked_ns.clear()
            self._beat_ns, self._heard_ns = _LONG_AGO_NS, now_ns
        self._now_ns = now_ns
        for packet in self._within_rate("control", now_ns):
            self._answer(packet, now_ns)
        if self.session.ident and now_ns - self._heard_ns > SILENCE_NS:
            self._end("the remote site is silent")
        for packet in self._within_rate("heartbeat", now_ns):
            self._heartbeat(packet, now_ns)
        for packet in self.link.newest("touch" if self.role == OPERATOR else "observed"):
            self._touch(packet, now_ns)
        self.session.heard(self.acceptance.gap_ns(now_ns), self.gap_s, "touch")
        if self.session.state is LinkState.FAULT:
            self._withdraw()
        self.stopping.step(now_ns, unconfirmed)
        if self.session.ident:
            self._keep_up(now_ns, not_ready)
        elif self._objected.over(now_ns):
            self._ask("hello", now_ns, {**self.capabilities, "role": self.role})

    def _keep_up(self, now_ns: int, not_ready: str) -> None:
        """Send heartbeats, and repeat the requests without an answer."""
        if now_ns - self._beat_ns >= _BEAT_NS:
            self._beat_ns = now_ns
            self._beat(now_ns)
        if self.role == OBSERVER:
            return
        if self.stopping.ask_remote:
            self._ask("estop", now_ns, {})
        remote_state = self.touch.state if self.touch is not None else LinkState.CONNECTED
        if remote_state is LinkState.FAULT:
            self._withdraw()
            if not self.remote_fault:
                self._ask("status", now_ns, {})
        elif self.remote_fault:
            self.remote_fault, self.refusal = None, ""
        interval_ns = _STATUS_NS if self.remote_patient is None and not self.remote_stale else _OFTEN_NS
        if now_ns - self._asked_ns.get("status", _LONG_AGO_NS) >= interval_ns:
            self._ask("status", now_ns, {})
        if self._remote_let_go():
            self._let_go(now_ns)
        elif self.both_engaged and now_ns - self._engaged_ns > _MOVED_NS:
            self._unmoved.reset()
        wants = self.want_engaged and self.session.state is LinkState.CONNECTED
        if self.engages_itself or not wants:
            self._wanted_ns = now_ns
        if self._in_time(wants) and wants and not not_ready and self._unmoved.over(now_ns):
            self._ask("engage", now_ns, {"max_age_s": self.max_age_s}, self._wanted_ns)

    def _let_go(self, now_ns: int) -> None:
        """Disengage with the remote site; where no motion reached it, wait before engaging again."""
        why, stale = "the remote site is no longer engaged", self.remote_stale
        self.session.disengage(f"{why}: {stale}" if stale else why)
        if not self.engages_itself:
            self._withdraw()
        elif stale:
            wait_s = self._unmoved.fail(now_ns)
            self.refusal = f"{NO_MOTION}; this site engages again after {wait_s:g} s"
            log.warning("%s", self.refusal)

    def _in_time(self, wants: bool) -> bool:
        """Return whether the clock offset is known well enough to judge the age of packets.

        A link that is too slow is a reason only where the site wants to engage, and until the link is fast again.
        """
        uncertainty_ns = self.clock.uncertainty_ns
        if uncertainty_ns is None:
            return False
        slow = uncertainty_ns > self.acceptance.max_age_ns
        if slow and wants and not self.refusal.startswith("the link is too slow"):
            self.refusal = (
                f"the link is too slow: a round trip of {2e-6 * uncertainty_ns:.0f} ms, packets may be "
                f"{1e-6 * self.acceptance.max_age_ns:.0f} ms old (link.max_age_s on both sites)"
            )
            log.warning("%s", self.refusal)
        elif not slow and self.refusal.startswith("the link is too slow"):
            self.refusal = ""
        return not slow

    def send_motion(self, now_ns: int, x_m: float, y_m: float, z_m: Sequence[float]) -> bytes | None:
        """Send the hand's place and the fingertips' heights (5,), m.

        Returns:
            The packet; None without a session, or where the deadband omits it.

        Raises:
            BadPacket, OverflowError: a value is out of range.
        """
        if not self.session.ident:
            return None
        state = self.session.state
        if state is LinkState.ENGAGED and not self._touch_arrives(now_ns):
            state = LinkState.CONNECTED  # a hand without touch must not move anything
        floats = pack_hand(x_m, y_m, z_m)
        if self.deadband is not None:
            now_s, rows = now_ns * 1e-9, motion_rows(floats)
            expected = self._expected.at(now_s)
            changed = state is not self._sent_state or expected is None or motion_perceptible(expected, rows)
            if not self.deadband.step(now_s, changed):
                return None
            self._expected.take(now_s, rows)
            self._sent_state = state
        self._motion_sequence += 1
        packet = motion_packet(self.session.ident, self._motion_sequence, now_ns, state, floats)
        self.link.send_latest("motion", packet)
        return packet

    def _touch_arrives(self, now_ns: int) -> bool:
        """Return whether touch arrives, without which the operator moves blindly."""
        gap_ns = self.acceptance.gap_ns(now_ns)
        return gap_ns is not None and 0 <= gap_ns <= self.gap_s * 1e9

    def request(self, verb: str, time_ns: int, details: dict[str, Any]) -> None:
        """Send a control request of this time; a later `step` takes its answer."""
        self._sequence += 1
        packet = Request(self.session.ident, self._sequence, time_ns, verb, details).encode()
        if self.link.send("control", packet):
            self._asked = {**dict(list(self._asked.items())[-20:]), self._sequence: verb}

    def engage(self) -> None:
        """Request engaging for a person: at once, also where earlier tries failed."""
        self.want_engaged = True
        self._unmoved.reset()

    def stop(self, now_ns: int) -> None:
        """Stop both sites in an emergency: latch here at once, and ask the remote site until it answers."""
        self._withdraw()
        self.stopping.begin(now_ns)

    def disengage(self, now_ns: int, why: str = "") -> None:
        """Bring both sites to neutral; engaging again needs a new request."""
        self._withdraw()
        self.session.disengage(why)
        self.request("disengage", now_ns, {})

    def _withdraw(self) -> None:
        """Request no engaging any more; the answer to an earlier request has no effect."""
        self.want_engaged = False
        self._asked = {sequence: verb for sequence, verb in self._asked.items() if verb != "engage"}

    def clear(self, now_ns: int) -> None:
        """Clear the latched fault of this site, and of the remote one if it allows that.

        Raises:
            Refused: neither site has a fault.
        """
        if self.remote_fault:
            self.refusal = ""
            self.request("clear_fault", now_ns, {})
            if self.session.state is not LinkState.FAULT:
                return
        self.session.clear()
        self._withdraw()

    def annotate(self, now_ns: int, text: str) -> None:
        """Request a note in the remote site's recording."""
        self.request("annotate", now_ns, {"text": text})

    def goodbye(self, now_ns: int) -> None:
        """Leave, so that the next operator need not wait for a time-out; an observer only stops."""
        if self.session.ident and self.role == OPERATOR:
            self.request("goodbye", now_ns, {})

    def _end(self, why: str) -> None:
        self.session.disconnect(why)
        self.want_engaged = self.want_engaged and self.engages_itself
        self._forget_status()
        self.stopping.remote_gone(why)

    def _ask(self, verb: str, now_ns: int, details: dict[str, Any], wanted_ns: int | None = None) -> None:
        """Send a request that is due; with the time since when it is wanted, ns, its repetitions have that time."""
        if now_ns - self._asked_ns.get(verb, _LONG_AGO_NS) >= _ASK_NS:
            self._asked_ns[verb] = now_ns
            self.request(verb, now_ns if wanted_ns is None else wanted_ns, details)

    def _within_rate(self, stream: str, now_ns: int) -> list[bytes]:
        """Return the packets of a request stream within the rate limit."""
        packets = self.link.receive(stream)
        if not packets:
            return packets
        allowed = [packet for packet in packets if self._rates.allows(stream, now_ns * 1e-9)]
        if len(allowed) < len(packets):
            self.damaged[f"{stream}: too many"] += len(packets) - len(allowed)
        return allowed

    def _answer(self, packet: bytes, now_ns: int) -> None:
        try:
            answer = Answer.decode(packet)
        except BadPacket as error:
            self._count_damaged("control", error)
            if isinstance(error, WrongVersion):
                self.refusal = f"the remote site cannot be understood: {error}"
            return
        if answer.sequence == 0 and answer.refused and answer.session == self.session.ident != 0:
            self._end(answer.refused)
            self._ended = self.refusal = answer.refused
            return
        verb = self._asked.pop(answer.sequence, "")
        if verb == "hello" and self.session.ident:
            return  # an earlier request was granted, and this one repeated it
        if verb in ("hello", "engage"):
            refusal = answer.refused or self._welcomed(verb, answer, now_ns)
            if refusal and refusal != self.refusal:
                log.warning("%s refused: %s", verb, refusal)
            self.refusal = refusal
            if refusal == ASKED_BEFORE and not self.engages_itself:
                self._withdraw()
        elif verb == "estop":
            self.stopping.answered(answer)
        elif verb == "status" and not answer.refused:
            self._status(answer.details, now_ns)
        elif verb == "clear_fault" and answer.refused:
            self.refusal = answer.refused
            log.warning("clear_fault refused: %s", answer.refused)

    def _status(self, details: dict[str, Any], now_ns: int) -> None:
        try:
            if self.touch is not None and self.touch.state is LinkState.FAULT:
                self.remote_fault = read_fault(details.get("fault"))
            recording, late, patient = recording_stopped(details), late_motion(details), remote_patient(details)
        except BadPacket as error:
            self._count_damaged("control", error)
            return
        if recording and recording != self.remote_recording:
            log.warning("the remote site's recording stopped: %s", recording)
        if late and not self._late_motion:
            log.warning("the remote site gets no motion: %s", late)
        self.remote_recording, self._late_motion = recording, late
        self.remote_patient, self.patient_ns = patient, now_ns

    def _forget_status(self) -> None:
        """Forget what the remote site reported, because the session is another."""
        self.remote_fault, self.remote_recording, self._late_motion, self.remote_patient = None, "", "", None

    def _welcomed(self, verb: str, answer: Answer, now_ns: int) -> str:
        """Take a granted hello or engage; return why this site refuses it, empty when it accepts."""
        if verb == "hello":
            return self._begin(answer, now_ns) or self._ended
        if answer.session == self.session.ident and self.session.state is LinkState.CONNECTED:
            agreed_s = answer.details.get("max_age_s")
            if not isinstance(agreed_s, float) or not 0.0 < agreed_s <= AGE_MAX_S:
                self.damaged["control"] += 1
                return ""
            agreed_s = min(agreed_s, self.max_age_s)
            self.acceptance.max_age_ns = round(agreed_s * 1e9)
            self.session.engage(f"packets up to {agreed_s * 1e3:.0f} ms old count")
            self._heard_ns = self._engaged_ns = now_ns
            self._ended = self._late_motion = ""
        return ""

    def _begin(self, answer: Answer, now_ns: int) -> str:
        ident = answer.details.get("session")
        first_motion = answer.details.pop("first_motion", 1)  # an observer gets none
        if type(ident) is not int or ident <= 0 or type(first_motion) is not int or first_motion <= 0:
            self.damaged["control"] += 1
            return ""
        self.remote = answer.details
        objection = self._objection(answer.details)
        if objection:
            self.session.ident = ident
            self.goodbye(now_ns)
            self.session.ident = 0
            self._objected.fail(now_ns)
            return objection
        self._objected.reset()
        self.want_engaged = self.want_engaged and self.engages_itself
        self.session.connect(ident, f"calibration {self.remote.get('calibration', 'unknown')}")
        self.clock = ClockOffset()
        self.touch = None
        self._forget_status()
        self.acceptance.restart()
        self.acceptance.max_age_ns = round(self.max_age_s * 1e9)
        self._motion_sequence = first_motion - 1
        self._expected = DeadReckoning()
        self._heard_ns = now_ns
        return ""

    def _objection(self, remote: dict[str, Any]) -> str:
        if self.role == OBSERVER:
            return misreading(remote)  # without outputs, fingers and rates do not matter
        found = remote.get("calibration")
        if self.calibration and found != self.calibration:
            return f"the remote site is calibrated with {found}, this site expects {self.calibration}"
        return disagreement(self.capabilities, remote, self.gap_s)

    def _beat(self, now_ns: int) -> None:
        self._sequence += 1
        beat = Heartbeat(
            self.session.ident,
            self._sequence,
            now_ns,
            self.session.state,
            now_ns,
            0,
            self.clock.offset_ns,
            self.clock.uncertainty_ns or 0,
        )
        self.link.send("heartbeat", beat.encode())

    def _heartbeat(self, packet: bytes, now_ns: int) -> None:
        try:
            beat = Heartbeat.decode(packet)
            if beat.session == self.session.ident:
                here_ns = now_ns if self.stamp_ns is None else self.stamp_ns()
                self.clock.add(beat.sent_ns, beat.arrived_ns, beat.time_ns, here_ns)
                self._heard_ns = now_ns
                if self.role == OPERATOR:
                    self._second.heard(now_ns, self.clock.round_trip_ns, 2 * (self.clock.uncertainty_ns or 0))
                    self.link.double(self._second.wanted and self.gap_s >= 3.0 * SECOND_REFRESH_S)
        except ValueError as error:
            self._count_damaged("heartbeat", error)

    def _touch(self, packet: bytes, now_ns: int) -> None:
        if packet == self.touch_packet:
            return
        try:
            touch = Touch.decode(packet)
        except BadPacket as error:
            self._count_damaged("touch", error)
            return
        clock = self.clock
        if self.acceptance.accept(touch, self.session.ident, now_ns, clock.offset_ns, clock.uncertainty_ns):
            self.touch, self.touch_packet = touch, packet

    def _remote_let_go(self) -> bool:
        """Return whether a fresh touch reports that the remote site is not engaged although this site is."""
        heard_ns = self.acceptance.last_ns
        if not self.session.engaged or self.touch is None or heard_ns is None:
            return False
        in_flight_ns = max(_ASK_NS, self.acceptance.max_age_ns)  # touch of this age may have left before the grant
        return heard_ns - self._engaged_ns > in_flight_ns and self.touch.state is not LinkState.ENGAGED

    def _count_damaged(self, stream: str, error: ValueError) -> None:
        self.damaged[stream] += 1
        log.debug("%s: %s", stream, error)
