"""The operator's end of a session, and a remote site whose messages the test sends, in virtual time."""

from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from common.link.capabilities import capabilities
from common.link.link import OperatorLink
from common.wire.messages import TOUCH_BLOCK, TOUCH_FIELDS, Touch
from common.wire.packets import LinkState
from common.wire.session_messages import Answer, Heartbeat, Request
from operator_site.session.session_client import SessionClient

MS = 1_000_000
IDENT = 4711
FIRST_MOTION = 10**12
ABLE = capabilities(("index",), 500.0, calibration="abc")
NOWHERE = TOUCH_BLOCK.to_bytes(np.zeros((5, len(TOUCH_FIELDS)), np.float32))


@dataclass
class Remote:
    """A remote site as its link shows it: beats as long as it lives, answers what the test lets it."""

    state: LinkState = LinkState.CONNECTED
    alive: bool = True
    asked: list[Request] = field(default_factory=list)
    answers: list[bytes] = field(default_factory=list)
    beats: list[bytes] = field(default_factory=list)
    now_ns: int = 10**12
    sequence: int = 0
    round_trip_ms: int = 0
    doubled: bool = False
    """Whether second connections are asked for."""

    def send(self, stream: str, packet: bytes) -> bool:
        if stream == "control":
            self.asked.append(Request.decode(packet))
        elif self.alive:
            beat = Heartbeat.decode(packet)
            there_ns = beat.sent_ns + self.round_trip_ms * MS // 2
            echo = (beat.session, beat.sequence, there_ns, self.state, beat.sent_ns, there_ns, 0, 0)
            self.beats.append(Heartbeat(*echo).encode())
        return True

    def receive(self, stream: str) -> list[bytes]:
        if stream == "control":
            taken, self.answers[:] = list(self.answers), []
            return taken
        latest_ns = self.now_ns - self.round_trip_ms * MS
        taken = [beat for beat in self.beats if Heartbeat.decode(beat).sent_ns <= latest_ns]
        self.beats = self.beats[len(taken) :]
        return taken

    def send_latest(self, stream: str, packet: bytes) -> None:
        pass

    def double(self, wanted: bool) -> None:
        self.doubled = wanted

    def newest(self, stream: str) -> list[bytes]:
        if not self.alive:
            return []
        self.sequence += 1
        return [Touch(IDENT, self.sequence, self.now_ns, self.state, NOWHERE, ("",) * 5, ()).encode()]

    def answer(self, verb: str, refused: str = "", **details: Any) -> None:
        """Answer the last request of a kind."""
        request = next(request for request in reversed(self.asked) if request.verb == verb)
        self.answers.append(Answer(IDENT, request.sequence, self.now_ns, refused, details).encode())

    def count(self, verb: str) -> int:
        return sum(request.verb == verb for request in self.asked)


@dataclass
class Pair:
    remote: Remote = field(default_factory=Remote)
    client: SessionClient = field(init=False)
    here: str = ""
    """Devices of this site that do not confirm."""

    def __post_init__(self) -> None:
        self.client = SessionClient(cast(OperatorLink, self.remote), dict(ABLE), 0.15, want_engaged=False)

    def run(self, ms: int = 2) -> None:
        for _ in range(0, ms, 2):
            self.remote.now_ns += 2 * MS
            self.client.step(self.remote.now_ns, "", lambda _: {"index tacttip": self.here, "exoskeleton": ""})

    def connect(self) -> None:
        self.run()
        self.remote.answer("hello", session=IDENT, first_motion=FIRST_MOTION, **ABLE)
        self.run(200)
        assert self.client.session.state is LinkState.CONNECTED

    def stop(self) -> None:
        self.client.stop(self.remote.now_ns)
        self.run(10)

    def answer(self, verb: str, refused: str = "", **details: Any) -> None:
        """The remote site answers the last request of a kind."""
        self.remote.answer(verb, refused, **details)
        self.run()

    def asked(self, verb: str, ms: int) -> int:
        """How often the remote site is asked in this time."""
        before = self.remote.count(verb)
        self.run(ms)
        return self.remote.count(verb) - before
