"""The remote site's end of the session: requests, heartbeats, observers, and accepted motion."""

import logging
import math
import secrets
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from common.faults.fault import Fault, FaultCode
from common.limits import AGE_MAX_S, GAP_S
from common.link.capabilities import OBSERVER, disagreement
from common.link.clock_offset import ReadClock
from common.link.curve import Sender, may_stop
from common.link.deadband import DeadReckoning, Places
from common.link.emergency_stop import EmergencyStop, Unconfirmed
from common.link.keys import fingerprint
from common.link.link_sides import RemoteSide
from common.link.packet_filter import PacketFilter
from common.link.rate_limiter import RateLimiters
from common.link.session_state import Refused, Session, note_text
from common.runtime.containment import Containment
from common.site_status import staleness
from common.timing.timeouts import MOTION_SILENCE_S, SESSION_SILENCE_S
from common.wire.messages import Motion
from common.wire.packets import SCHEMA_VERSION, BadPacket, LinkState, WrongVersion
from common.wire.session_messages import (
    ASKED_BEFORE,
    DESK_REQUESTS,
    LONGEST_REFUSAL,
    REMOTE_DESK_REQUESTS,
    Answer,
    Heartbeat,
    Request,
)
from remote_site.session.operator_connections import OperatorConnections

log = logging.getLogger(__name__)

_NEVER_NS = -math.inf
SILENCE_NS = round(SESSION_SILENCE_S * 1e9)
"""Time without a heartbeat that ends the session, ns; then another operator may connect."""
SETTLED_NS = 1_500_000_000
"""Grace period in which the operator's site may still report disengaged, ns: our message may be in flight."""
PACKETS_PER_S = 40.0
"""Maximum rate of one key's requests, or heartbeats, 1/s; a site sends at most 20 heartbeats and 10 requests."""
PACKETS_AT_ONCE = 80
"""Maximum burst of one key's requests, or heartbeats, after a pause of the network."""
_ONE_OPERATOR = "another operator is connected: one operator per remote site"
_SECRET_BITS = 52
_TWICE_NS = 1_000_000_000
"""Time since a motion that came a second time in which the operator still has two connections, ns."""
EXPELLED_S = 10.0
"""Time for which a key is refused at a stream after its connection was ended, s; the operator's key never is."""


@dataclass(slots=True)
class SessionServer:
    """Serves one operator at a time, and any observers. Time is an argument, ns of this site's monotonic clock."""

    link: RemoteSide
    capabilities: dict[str, Any]
    max_age_s: float
    gap_s: float = GAP_S
    stamp_ns: ReadClock | None = None
    session: Session = field(default_factory=Session)
    operator: str = ""
    """Public key of the session's operator, as the link authenticated it; empty without a session."""
    motion: Motion | None = None
    """The newest accepted motion of this session."""
    acceptance: PacketFilter = field(init=False)
    damaged: Counter[str] = field(default_factory=Counter)
    stopping: EmergencyStop = field(default_factory=EmergencyStop)
    stopped: str = ""
    """Outcome of the last emergency stop; empty while it is under way, or without one."""
    observers: dict[str, int] = field(default_factory=dict)
    """Keys of the observers, with the time of the last packet, ns."""
    recording_stopped: Callable[[], str] = str
    """Returns why this site's recording stopped; empty while it works."""
    patient: Callable[[], dict[str, Any]] = dict
    """Returns what the patient reports, and the limit that follows it; empty without a pain slider."""
    contain: Containment = field(default_factory=Containment)
    """Counts exceptions of requests."""
    expelled: Counter[str] = field(default_factory=Counter)
    """Number of ended connections by stream."""
    _connections: OperatorConnections = field(init=False)
    _rates: RateLimiters[tuple[str, str, bool]] = field(init=False)
    _ended: RateLimiters[tuple[str, str, int]] = field(default_factory=lambda: RateLimiters(1.0, 1))
    _lines_of_log: RateLimiters[str] = field(default_factory=lambda: RateLimiters(0.1, 5))
    _hand: DeadReckoning = field(default_factory=DeadReckoning)
    _notes: list[str] = field(default_factory=list)
    _heard_ns: int = 0
    _first_motion: int = 0
    """Sequence number of the session's first motion, which only its operator knows."""
    _asked: int = -1
    """Sequence of the operator's last request in this session."""
    _awaits_beat: bool = False
    """Whether the operator has sent no heartbeat in this session yet, so that it may not know of it."""
    _now_ns: int = 0
    _left_ns: float = _NEVER_NS
    """Time when a person here last disengaged or cleared a fault, ns; a request from before engages nothing."""
    _agreed_ns: int = 0
    """Time when both sites last were engaged, or this one was asked to engage, ns."""
    _offset_ns: int = 0
    _uncertainty_ns: int | None = None
    _stop_asked: list[tuple[bytes, int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.acceptance = PacketFilter(max_age_ns=round(self.max_age_s * 1e9))
        self._connections = OperatorConnections(self.link.is_open)
        self._rates = RateLimiters(PACKETS_PER_S, PACKETS_AT_ONCE)

    def step(self, now_ns: int, not_ready: str, unconfirmed: Unconfirmed = lambda _: {}) -> None:
        """Answer requests and heartbeats, and take the newest motion.

        Args:
            now_ns: this site's clock, ns.
            not_ready: reason why the site may not engage, such as a missing device; empty when it may.
            unconfirmed: returns for each device why its outputs may not be off since a time, s.
        """
        if now_ns < self._now_ns:
            self._heard_ns, self._left_ns = min(self._heard_ns, now_ns), _NEVER_NS  # the clock was set back
        self._now_ns = now_ns
        if self.session.ident and now_ns - self._heard_ns > SILENCE_NS:
            self._end("the operator is silent")
        if self.observers:
            self.observers = {key: ns for key, ns in self.observers.items() if now_ns - ns <= SILENCE_NS}
        for sender, packet in self.link.requests("control"):
            if self._within_rate("control", sender, packet, now_ns):
                self._control(sender, packet, now_ns, not_ready)
        if beats := self.link.requests("heartbeat"):
            for sender, packet in self._connections.own_first("heartbeat", beats):
                if self._within_rate("heartbeat", sender, packet, now_ns):
                    with self.contain.step("heartbeat", latches=False):
                        self._heartbeat(sender, packet, now_ns)
        if motions := self.link.newest_of_each("motion"):
            for sender, packet in motions:
                self._motion(sender, packet, now_ns)
        self.session.heard(self.acceptance.gap_ns(now_ns), self.gap_s, "motion")
        if why := self._motion_refused():
            self._answer(self._connections.answers_to, 0, now_ns, why)
            self._end(why)
        if why := self._operator_let_go(now_ns):
            self.session.disengage(why)
        self._confirm_stop(now_ns, unconfirmed)

    @property
    def both_engaged(self) -> bool:
        """Whether both sites say that outputs may act."""
        motion = self.motion
        return motion is not None and self.session.state is motion.state is LinkState.ENGAGED

    def on_two_connections(self, now_ns: int) -> bool:
        """Return whether the operator's motion, and so this site's touch, goes over two connections."""
        overtaken_ns = self.acceptance.overtaken_ns
        return overtaken_ns is not None and now_ns - overtaken_ns <= _TWICE_NS

    def places(self, now_ns: int) -> Places | None:
        """Return where the operator's fingertips are now by the newest motions; None before the session's first motion.

        Time counts from the arrival of the newest: its delay on the way remains.
        """
        gap_ns = self.acceptance.gap_ns(now_ns)
        if self.motion is None or gap_ns is None:
            return None
        return self._hand.at((self.motion.time_ns + gap_ns) * 1e-9)

    def stop(self, now_ns: int, *, here: bool) -> None:
        """Stop in an emergency: latch at once, and wait for the devices to confirm.

        Args:
            now_ns: this site's clock, ns.
            here: whether a person at this site requests it; then only a person at this site may clear it.
        """
        self.stopped = ""
        code = FaultCode.REMOTE_STOP if here else FaultCode.OPERATOR_STOP
        self.session.latch(Fault(code), cleared_here_only=here)
        self.stopping.ask(now_ns)

    def disengage(self, now_ns: int) -> None:
        """Bring outputs to neutral for a person here; a request to engage from before has no effect."""
        self.session.disengage("asked for at the remote site")
        self._left_ns = now_ns

    def clear(self, now_ns: int) -> None:
        """Clear the latched fault for a person here; a request to engage from before has no effect.

        Raises:
            Refused: no fault is latched.
        """
        self.session.clear()
        self._left_ns = now_ns

    def cut(self, keys: set[str]) -> None:
        """End the session, or the observation, of the owners of revoked keys."""
        if self.operator in keys:
            self._end("the operator's key was revoked")
        for key in keys:
            self.observers.pop(key, None)

    def take_notes(self) -> list[str]:
        """Return the operator's notes since the last call."""
        notes, self._notes = self._notes, []
        return notes

    def _end(self, why: str, *, left: bool = False) -> None:
        self.session.disconnect(why, left=left)
        self.operator = ""

    def _within_rate(self, stream: str, sender: Sender, packet: bytes, now_ns: int) -> bool:
        """Return whether a key keeps its rate limit; otherwise end its connection, but still accept a stop."""
        operators = sender.key == self.operator
        own = operators and self._connections.own(stream, sender, now_ns)
        if self._rates.allows((stream, sender.key, own), now_ns * 1e-9):
            return True
        self._expel(stream, sender, now_ns, f"sends more than {PACKETS_PER_S:g} packets a second")
        return operators and stream == "control" and may_stop(packet) and _is_stop(packet)

    def _expel(self, stream: str, sender: Sender, now_ns: int, why: str) -> None:
        """End a connection; the operator's key may connect again at once."""
        if not self._ended.allows((stream, sender.key, sender.connection), now_ns * 1e-9):
            return  # a packet that was read before the connection ended
        self.expelled[stream] += 1
        self._log(sender.key, now_ns, f"ended a connection to {stream}: {why}")
        self.link.expel(stream, sender, 0.0 if sender.key == self.operator else EXPELLED_S)

    def _log(self, key: str, now_ns: int, text: str) -> None:
        """Log a text about a key, within a rate limit."""
        if self._lines_of_log.allows(key, now_ns * 1e-9):
            log.warning("%s: %s", fingerprint(key), text)

    def _motion(self, sender: Sender, packet: bytes, now_ns: int) -> None:
        if sender.key != self.operator:
            self.acceptance.refused["key"] += 1
            if self.operator:
                self._expel("motion", sender, now_ns, "only the session's operator moves the telemanipulator")
            return
        try:
            motion = Motion.decode(packet)
        except BadPacket as error:
            self._count_damaged("motion", error)
            return
        # The operator estimates (remote - operator); the sender of a motion is the operator.
        offset_ns = -self._offset_ns
        if self.acceptance.accept(motion, self.session.ident, now_ns, offset_ns, self._uncertainty_ns):
            self.motion = motion
            self._hand.take(motion.time_ns * 1e-9, motion.rows)
        elif self.acceptance.latest_refusal == "sequence":  # only the operator knows the session's first number
            self.session.latch(Fault(FaultCode.KEY_USED_TWICE))
            self._expel("motion", sender, now_ns, "a copy of the operator's key sends motion")

    def _motion_refused(self) -> str:
        """Return why motion has been refused permanently despite heartbeats; empty when it is accepted."""
        why = self.acceptance.latest_refusal
        if not why or not self.session.engaged:
            return ""
        since_ns = max(self._agreed_ns, self.acceptance.last_ns or 0)
        if self.acceptance.refused_ns - since_ns <= SILENCE_NS:
            return ""
        return f"motion has been refused for {SESSION_SILENCE_S:g} s: {why}"

    def _operator_let_go(self, now_ns: int) -> str:
        """Return how the operator let go of the engaged session; empty otherwise.

        Its site reports disengaged for longer than the grace period, or no motion comes.
        """
        if not self.session.engaged:
            return ""
        motion, heard_ns = self.motion, self.acceptance.last_ns
        if motion is not None and heard_ns is not None:
            if motion.state is LinkState.ENGAGED:
                self._agreed_ns = heard_ns
            if heard_ns - self._agreed_ns > SETTLED_NS:
                return "the operator's site is no longer engaged"
        silent_ns = now_ns - max(self._agreed_ns, heard_ns or 0)
        return f"no motion for {MOTION_SILENCE_S:g} s" if silent_ns > MOTION_SILENCE_S * 1e9 else ""

    def _heartbeat(self, sender: Sender, packet: bytes, now_ns: int) -> None:
        try:
            beat = Heartbeat.decode(packet)
        except BadPacket as error:
            self._count_damaged("heartbeat", error)
            return
        if beat.session != self.session.ident or not self.session.ident:
            return
        if sender.key == self.operator:
            if not self._connections.own("heartbeat", sender, now_ns):
                return
            self._heard_ns, self._awaits_beat = now_ns, False
            self._offset_ns, self._uncertainty_ns = beat.offset_ns, beat.uncertainty_ns or None
        elif sender.key in self.observers:
            self.observers[sender.key] = now_ns
        arrived_ns = now_ns if self.stamp_ns is None else self.stamp_ns()
        answer = Heartbeat(
            beat.session,
            beat.sequence,
            arrived_ns,
            self.session.state,
            beat.sent_ns,
            arrived_ns,
            beat.offset_ns,
            beat.uncertainty_ns,
        )
        self.link.answer("heartbeat", sender.who, answer.encode())

    def _control(self, sender: Sender, packet: bytes, now_ns: int, not_ready: str) -> None:
        try:
            request = Request.decode(packet)
        except WrongVersion as error:
            # The far side cannot decode the answer either, but finds this site's version in it.
            self._count_damaged("control", error)
            self._answer(sender.who, 0, now_ns, f"this site speaks schema version {SCHEMA_VERSION}")
            return
        except BadPacket as error:
            self._count_damaged("control", error)
            return
        try:
            with self.contain.request("control"):
                details = self._do(request, sender, now_ns, not_ready)
                if request.verb == "estop":
                    self._stop_asked.append((sender.who, request.sequence))  # answered once the devices confirm
                else:
                    self._answer(sender.who, request.sequence, now_ns, "", details)
        except (Refused, BadPacket) as error:  # BadPacket: a text of the request, or the answer, is too long
            self._log(sender.key, now_ns, f"refused {request.verb}: {error}")
            self._answer(sender.who, request.sequence, now_ns, str(error))

    def _answer(
        self, who: bytes, sequence: int, now_ns: int, refused: str, details: dict[str, Any] | None = None
    ) -> None:
        answer = Answer(self.session.ident, sequence, now_ns, refused[:LONGEST_REFUSAL], details or {})
        self.link.answer("control", who, answer.encode())

    def _confirm_stop(self, now_ns: int, unconfirmed: Unconfirmed) -> None:
        if self.stopping.asked_ns is None:
            return
        confirmation = self.stopping.step(now_ns, unconfirmed)
        if self.session.state is not LinkState.FAULT:
            self.stopping.forget()
        if confirmation is None:
            return
        self.stopped = str(confirmation)
        self.session.note("estop", str(confirmation))
        for who, sequence in self._stop_asked:
            details = {"after_s": confirmation.after_s, "unconfirmed": confirmation.unconfirmed}
            self._answer(who, sequence, now_ns, "", details)
        self._stop_asked.clear()

    def _do(self, request: Request, sender: Sender, now_ns: int, not_ready: str) -> dict[str, Any]:
        session = self.session
        if request.verb == "hello":
            observes = request.details.get("role") == OBSERVER
            return self._observe(sender.key, now_ns) if observes else self._hello(request, sender, now_ns)
        if request.verb == "status":
            status = {"state": session.state.name.lower(), "fault": session.fault, "missing": not_ready}
            stale = staleness(self, "motion", now_ns, self.gap_s)
            recording = self.recording_stopped()[:LONGEST_REFUSAL]
            return {**status, "recording": recording, "stale": stale, **self.patient()}
        self._check(request, sender.key)
        if request.verb == "estop":  # accepted with any sequence and connection
            self.stop(now_ns, here=False)
            return {}
        if not self._connections.own("control", sender, now_ns):
            raise Refused("the session's operator asks on another connection")
        if request.sequence <= self._asked:
            raise Refused("an old request")
        self._asked = request.sequence
        details: dict[str, Any] = {}
        match request.verb:
            case "engage":
                earliest_ns = request.time_ns + self._offset_ns - (self._uncertainty_ns or 0)
                if earliest_ns <= self._left_ns:  # repeated until it was granted, or late
                    raise Refused(ASKED_BEFORE)
                if not_ready:
                    raise Refused(f"not ready: {not_ready}")
                agreed_s = details["max_age_s"] = self._agree_on_age(request)
                session.engage(f"packets up to {agreed_s * 1e3:.0f} ms old count")
                self._agreed_ns = now_ns
            case "disengage":
                session.disengage("the operator asked")
            case "clear_fault":
                session.clear(here=False)
            case "annotate":
                self._notes.append(note_text(request.details))
            case "goodbye":
                self._end("the operator said goodbye", left=True)
        return details

    def _check(self, request: Request, key: str) -> None:
        """Raise Refused unless the request is of the session's operator."""
        if request.session != self.session.ident or not self.session.ident:
            raise Refused("that is not the present session: say hello first")
        if key != self.operator:
            raise Refused("only the session's operator may ask for that: observers look on")
        if request.verb in DESK_REQUESTS:
            raise Refused("that is for the desk of the operator's own site")
        if request.verb in REMOTE_DESK_REQUESTS:
            raise Refused("that is for a person at the remote site, who sees the patient")

    def _agree_on_age(self, request: Request) -> float:
        """Return the stricter of both sites' limits on the age of packets, s, which holds for both."""
        theirs = request.details.get("max_age_s", self.max_age_s)
        if not isinstance(theirs, float) or not 0.0 < theirs <= AGE_MAX_S:
            raise Refused(f"max_age_s must be above 0 and at most {AGE_MAX_S:g} s")
        agreed_s = min(theirs, self.max_age_s)
        self.acceptance.max_age_ns = round(agreed_s * 1e9)
        return agreed_s

    def _observe(self, key: str, now_ns: int) -> dict[str, Any]:
        if not self.session.ident:
            raise Refused("there is nothing to observe: no operator is connected")
        if key == self.operator:
            raise Refused("this key is the operator's: an observer needs one of its own")
        self.observers[key] = now_ns
        return {"session": self.session.ident, **self.capabilities}

    def _hello(self, request: Request, sender: Sender, now_ns: int) -> dict[str, Any]:
        key = sender.key
        if not self.link.may_operate(key):
            raise Refused("this key is trusted as an observer's only")
        if self.session.ident and not (key == self.operator and self._awaits_beat):
            raise Refused(_ONE_OPERATOR)
        problem = disagreement(self.capabilities, request.details, self.gap_s)
        if problem:
            raise Refused(problem)
        if self.session.ident:  # repeated before the answer arrived: the same session
            if not self._connections.own("control", sender, now_ns):
                raise Refused(_ONE_OPERATOR)
            # A site that has started again counts its packets again.
            self._asked = request.sequence
            self.acceptance.restart(self._first_motion)
            return self._welcome()
        self.operator, self._awaits_beat, self._asked = key, True, request.sequence
        self._connections.begin(sender, now_ns)
        self.link.forgive(key)
        self.session.connect(secrets.randbits(62) + 1, f"operator {fingerprint(key)}")
        self.motion, self._left_ns = None, _NEVER_NS
        self._hand = DeadReckoning()
        self._first_motion = secrets.randbits(_SECRET_BITS) + 1
        self.acceptance.restart(self._first_motion)
        self.acceptance.max_age_ns = round(self.max_age_s * 1e9)
        self._uncertainty_ns = None
        self._heard_ns = now_ns
        return self._welcome()

    def _welcome(self) -> dict[str, Any]:
        return {"session": self.session.ident, "first_motion": self._first_motion, **self.capabilities}

    def _count_damaged(self, stream: str, error: BadPacket) -> None:
        self.damaged[stream] += 1
        log.debug("%s: %s", stream, error)


def _is_stop(packet: bytes) -> bool:
    try:
        return Request.decode(packet).verb == "estop"
    except BadPacket:
        return False
