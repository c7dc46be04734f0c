"""The remote site's end of the session: requests, heartbeat, and which motion may be acted on."""

import logging
import secrets
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from common.acceptance import Acceptance
from common.link import RemoteLink
from common.messages import Motion
from common.packets import BadPacket, LinkState
from common.session import Refused, Session
from common.session_messages import LONGEST_REFUSAL, Answer, Heartbeat, Request

log = logging.getLogger(__name__)

SILENCE_NS = 1_000_000_000
"""No heartbeat for this long ends the session: another operator may come, and this one says hello again."""


@dataclass(slots=True)
class SessionServer:
    """Serves one operator at a time. Time is an argument, ns of this site's monotonic clock."""

    link: RemoteLink
    capabilities: dict[str, Any]
    max_age_s: float
    session: Session = field(default_factory=Session)
    motion: Motion | None = None
    """The newest accepted motion of this session."""
    acceptance: Acceptance = field(init=False)
    damaged: Counter[str] = field(default_factory=Counter)
    _notes: list[str] = field(default_factory=list)
    _heard_ns: int = 0
    _offset_ns: int = 0
    _uncertainty_ns: int | None = None

    def __post_init__(self) -> None:
        self.acceptance = Acceptance(max_age_ns=round(self.max_age_s * 1e9))

    def step(self, now_ns: int, ready: str) -> None:
        """Answer what came and take the newest motion.

        Args:
            now_ns: this site's clock.
            ready: empty when the devices allow engaging, else what is missing.
        """
        if self.session.ident and now_ns - self._heard_ns > SILENCE_NS:
            log.warning("the operator is silent: session ended")
            self.session.disconnect()
        for who, packet in self.link.requests("control"):
            self._control(who, packet, now_ns, ready)
        for who, packet in self.link.requests("heartbeat"):
            self._heartbeat(who, packet, now_ns)
        packet_or_none = self.link.receive_latest("motion")
        if packet_or_none is not None:
            self._motion(packet_or_none, now_ns)

    @property
    def both_engaged(self) -> bool:
        """Whether both sites say that outputs may act."""
        return self.session.engaged and self.motion is not None and self.motion.state is LinkState.ENGAGED

    def _motion(self, packet: bytes, now_ns: int) -> None:
        try:
            motion = Motion.decode(packet)
        except BadPacket as error:
            self._count_damaged("motion", error)
            return
        # What the operator found is (remote - operator); a motion packet's sender is the operator.
        offset_ns = -self._offset_ns
        if self.acceptance.accept(motion, self.session.ident, now_ns, offset_ns, self._uncertainty_ns):
            self.motion = motion

    def _heartbeat(self, who: bytes, packet: bytes, now_ns: int) -> None:
        try:
            beat = Heartbeat.decode(packet)
        except BadPacket as error:
            self._count_damaged("heartbeat", error)
            return
        if beat.session != self.session.ident or not self.session.ident:
            return
        self._heard_ns = now_ns
        self._offset_ns, self._uncertainty_ns = beat.offset_ns, beat.uncertainty_ns or None
        answer = Heartbeat(
            beat.session,
            beat.sequence,
            now_ns,
            self.session.state,
            beat.sent_ns,
            now_ns,
            beat.offset_ns,
            beat.uncertainty_ns,
        )
        self.link.answer("heartbeat", who, answer.encode())

    def _control(self, who: bytes, packet: bytes, now_ns: int, ready: str) -> None:
        try:
            request = Request.decode(packet)
        except BadPacket as error:
            self._count_damaged("control", error)
            return
        refused, details = "", {}
        try:
            details = self._do(request, now_ns, ready)
        except (Refused, BadPacket) as error:
            refused = str(error)[:LONGEST_REFUSAL]
            log.info("refused %s: %s", request.verb, refused)
        answer = Answer(self.session.ident, request.sequence, now_ns, refused, details)
        self.link.answer("control", who, answer.encode())

    def _do(self, request: Request, now_ns: int, ready: str) -> dict[str, Any]:
        if request.verb == "hello":
            return self._hello(request, now_ns)
        if request.session != self.session.ident or not self.session.ident:
            raise Refused("that is not the present session: say hello first")
        match request.verb:
            case "engage":
                if ready:
                    raise Refused(f"not ready: {ready}")
                self.session.engage()
            case "disengage":
                self.session.disengage()
            case "estop":
                self.session.latch("emergency stop")
            case "clear_fault":
                self.session.clear()
            case "annotate":
                self._annotate(request)
        log.info("%s: now %s", request.verb, self.session.state.name.lower())
        return {}

    def take_notes(self) -> list[str]:
        """What the operator noted since the last call."""
        notes, self._notes = self._notes, []
        return notes

    def _annotate(self, request: Request) -> None:
        text = request.details.get("text")
        if not isinstance(text, str) or not text:
            raise Refused("a note needs a text")
        self._notes.append(text)

    def _hello(self, request: Request, now_ns: int) -> dict[str, Any]:
        if self.session.ident and request.session != self.session.ident:
            raise Refused("another operator is connected: one operator per remote site")
        theirs, ours = request.details.get("fingers"), self.capabilities["fingers"]
        if theirs != ours:
            raise Refused(f"the operator has fingers {theirs}, this site has {ours}: configure the same on both")
        self.session.connect(secrets.randbits(62) + 1)
        self.motion = None
        self.acceptance.restart()
        self._uncertainty_ns = None
        self._heard_ns = now_ns
        log.info("session %x with an operator", self.session.ident)
        return {"session": self.session.ident, **self.capabilities}

    def _count_damaged(self, stream: str, error: BadPacket) -> None:
        self.damaged[stream] += 1
        log.debug("%s: %s", stream, error)
