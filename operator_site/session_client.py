"""The operator site's end of the session: hello, clock comparison, engaging, and which touch may be rendered."""

import logging
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from common.acceptance import Acceptance
from common.clock import ClockOffset
from common.link import OperatorLink
from common.messages import Motion, Touch
from common.packets import BadPacket, Floats, LinkState
from common.session import Session
from common.session_messages import Answer, Heartbeat, Request
from common.streams import STREAMS

log = logging.getLogger(__name__)

SILENCE_NS = 1_000_000_000
"""No answer to heartbeats for this long: the remote site is gone, say hello again."""
_ASK_NS = 200_000_000
"""Between two tries of hello or engage."""
_BEAT_NS = round(1e9 / STREAMS["heartbeat"].rate_hz)


@dataclass(slots=True)
class SessionClient:
    """Finds the remote site again whenever it is gone. Time is an argument, ns of this site's monotonic clock."""

    link: OperatorLink
    capabilities: dict[str, Any]
    max_age_s: float
    want_engaged: bool
    session: Session = field(default_factory=Session)
    clock: ClockOffset = field(default_factory=ClockOffset)
    touch: Touch | None = None
    """The newest accepted touch of this session."""
    acceptance: Acceptance = field(init=False)
    damaged: Counter[str] = field(default_factory=Counter)
    refusal: str = ""
    """Why the remote site refused the last hello or engage; empty when it did not."""
    _sequence: int = 0
    """Of requests and heartbeats: it goes on across sessions, so that no old answer is taken for a new one."""
    _motion_sequence: int = 0
    _asked_ns: int = 0
    _asked: dict[int, str] = field(default_factory=dict)
    _beat_ns: int = 0
    _heard_ns: int = 0

    def __post_init__(self) -> None:
        self.acceptance = Acceptance(max_age_ns=round(self.max_age_s * 1e9))

    @property
    def both_engaged(self) -> bool:
        """Whether both sites say that outputs may act."""
        return self.session.engaged and self.touch is not None and self.touch.state is LinkState.ENGAGED

    def step(self, now_ns: int, ready: str) -> None:
        """Take what came, ask for what is missing.

        Args:
            now_ns: this site's clock.
            ready: empty when the devices allow engaging, else what is missing.
        """
        for packet in self.link.receive("control"):
            self._answer(packet, now_ns)
        if self.session.ident and now_ns - self._heard_ns > SILENCE_NS:
            log.warning("the remote site is silent: session ended")
            self.session.disconnect()
        for packet in self.link.receive("heartbeat"):
            self._heartbeat(packet, now_ns)
        packet_or_none = self.link.receive_latest("touch")
        if packet_or_none is not None:
            self._touch(packet_or_none, now_ns)
        if not self.session.ident:
            self._ask("hello", now_ns, self.capabilities)
            return
        if now_ns - self._beat_ns >= _BEAT_NS:
            self._beat_ns = now_ns
            self._beat(now_ns)
        if self._remote_let_go(now_ns):
            log.warning("the remote site is no longer engaged")
            self.session.disengage()
        waiting = self.session.state is LinkState.CONNECTED and self.clock.uncertainty_ns is not None
        if self.want_engaged and waiting and not ready:
            self._ask("engage", now_ns, {})

    def send_motion(self, now_ns: int, block: Floats) -> bytes | None:
        """Send the fingertips' places (5, 3), m; returns the packet, or None while there is no session."""
        if not self.session.ident:
            return None
        self._motion_sequence += 1
        packet = Motion(self.session.ident, self._motion_sequence, now_ns, self.session.state, block).encode()
        self.link.send_latest("motion", packet)
        return packet

    def request(self, verb: str, now_ns: int, details: dict[str, Any]) -> None:
        """Send a control request; its answer is taken by a later `step`."""
        self._sequence += 1
        packet = Request(self.session.ident, self._sequence, now_ns, verb, details).encode()
        if self.link.send("control", packet):
            self._asked = {**dict(list(self._asked.items())[-20:]), self._sequence: verb}

    def _ask(self, verb: str, now_ns: int, details: dict[str, Any]) -> None:
        if now_ns - self._asked_ns >= _ASK_NS:
            self._asked_ns = now_ns
            self.request(verb, now_ns, details)

    def _answer(self, packet: bytes, now_ns: int) -> None:
        try:
            answer = Answer.decode(packet)
        except BadPacket as error:
            self._count_damaged("control", error)
            return
        verb = self._asked.pop(answer.sequence, "")
        if verb in ("hello", "engage") and answer.refused != self.refusal:
            self.refusal = answer.refused
            if self.refusal:
                log.warning("%s refused: %s", verb, self.refusal)
        if answer.refused:
            return
        if verb == "hello" and not self.session.ident:
            self._begin(answer, now_ns)
        elif verb == "engage" and answer.session == self.session.ident and self.session.state is LinkState.CONNECTED:
            self.session.engage()
            self._heard_ns = now_ns
            log.info("engaged")

    def _begin(self, answer: Answer, now_ns: int) -> None:
        ident = answer.details.get("session")
        if type(ident) is not int or ident <= 0:
            self.damaged["control"] += 1
            return
        self.session.connect(ident)
        self.clock = ClockOffset()
        self.touch = None
        self.acceptance.restart()
        self._motion_sequence = 0
        self._heard_ns = now_ns
        log.info("session %x with the remote site", ident)

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
                self.clock.add(beat.sent_ns, beat.arrived_ns, beat.time_ns, now_ns)
                self._heard_ns = now_ns
        except ValueError as error:
            self._count_damaged("heartbeat", error)

    def _touch(self, packet: bytes, now_ns: int) -> None:
        try:
            touch = Touch.decode(packet)
        except BadPacket as error:
            self._count_damaged("touch", error)
            return
        clock = self.clock
        if self.acceptance.accept(touch, self.session.ident, now_ns, clock.offset_ns, clock.uncertainty_ns):
            self.touch = touch

    def _remote_let_go(self, now_ns: int) -> bool:
        """Whether a fresh touch says that the remote site is not engaged although this side is."""
        if not self.session.engaged or self.touch is None:
            return False
        settled = now_ns - self._asked_ns > _ASK_NS
        return settled and self.touch.state is not LinkState.ENGAGED

    def _count_damaged(self, stream: str, error: ValueError) -> None:
        self.damaged[stream] += 1
        log.debug("%s: %s", stream, error)
