"""An attacker who holds a trusted key: the packets of each role, one step at a time, over any link."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, Protocol

import numpy as np

from common.link.capabilities import capabilities
from common.wire.messages import MOTION_BLOCK, Motion, Touch
from common.wire.packets import MAX_PACKET, BadPacket, LinkState
from common.wire.session_messages import Answer, Heartbeat, Request

MS = 1_000_000
FAR_M = 0.5
"""Where attackers send the hand, m; no script of an operator's hand goes there."""
REFUSED_VERBS = ("engage", "disengage", "clear_fault", "annotate", "goodbye")
"""Requests that only the operator's own connection may make; a stop counts from any connection of its key."""
REQUESTS_A_STEP = 60
"""Requests of one step of a flood; a key may send 40 a second."""


class Line(Protocol):
    """What an attacker sends and hears through: the link's streams, `motion`, `touch`, `control` and the others."""

    def send(self, stream: str, packet: bytes) -> object:
        """Send a packet; never waits."""

    def receive(self, stream: str) -> list[bytes]:
        """What came on a stream since the last call."""


class Attacker:
    """Sends packets that every decoder accepts.

    Attributes:
        ident: number of the session, heard in touch as every trusted reader hears it.
        refused: reasons of the answers that it was given, in order; "" where its request was granted.
    """

    def __init__(self, line: Line, now_ns: Callable[[], int], fingers: tuple[str, ...] = ("index",)) -> None:
        """`now_ns`: the operator's clock, which its attackers know as well as the operator does."""
        self.line = line
        self.ident = 0
        self.refused: list[str] = []
        self._now_ns = now_ns
        self._able = capabilities(fingers, 500.0, max_age_s=0.15)
        self._sequence = self._motions = 9_000

    def listen(self) -> None:
        """Learn the session's number, and how requests were answered."""
        for packet in (*self.line.receive("touch"), *self.line.receive("observed")):
            self.ident = Touch.decode(packet).session
        self.refused += [Answer.decode(packet).refused for packet in self.line.receive("control")]
        self.line.receive("heartbeat")

    def ask(self, verb: str, **details: Any) -> None:
        """Make a request of the session, with a sequence number above all before."""
        self._sequence += 1
        self.line.send("control", Request(self.ident, self._sequence, self._now_ns(), verb, details).encode())

    def hello(self, role: str) -> None:
        """Ask for a session of one's own, or to look on."""
        self.ask("hello", **self._able, role=role)

    def beat(self, offset_ns: int = 0, uncertainty_ns: int = MS) -> None:
        """Send a heartbeat that says how the clocks differ."""
        now_ns = self._now_ns()
        beat = Heartbeat(self.ident, 1, now_ns, LinkState.ENGAGED, now_ns, 0, offset_ns, uncertainty_ns)
        self.line.send("heartbeat", beat.encode())

    def move(self, ahead: int = 1) -> None:
        """Send the hand to FAR_M, `ahead` sequence numbers further."""
        self._motions += ahead
        block = np.full((5, 3), (FAR_M, FAR_M, -0.01), np.float32)
        motion = Motion(self.ident, self._motions, self._now_ns(), LinkState.ENGAGED, MOTION_BLOCK.to_bytes(block))
        self.line.send("motion", motion.encode())

    def flood(self, size: str) -> None:
        """Many packets to every stream, `small` valid ones or the `largest`."""
        large = size == "largest"
        for _ in range(REQUESTS_A_STEP):
            if large:
                for stream in ("motion", "heartbeat", "control"):
                    self.line.send(stream, bytes(MAX_PACKET))
            else:
                self.ask("annotate", text="x")
                self.beat()
                self.move()


def _second_operator(attacker: Attacker) -> None:
    attacker.move()


def _refused_operator(attacker: Attacker) -> None:
    attacker.hello("operator")
    attacker.beat()
    attacker.move()


def _far_ahead(attacker: Attacker) -> None:
    attacker.move(ahead=9_999)


def _asks(attacker: Attacker) -> None:
    for verb in (*REFUSED_VERBS, "estop"):
        attacker.ask(verb, text="x", max_age_s=0.15)


def _clone_asks(attacker: Attacker) -> None:
    for verb in REFUSED_VERBS:
        attacker.ask(verb, text="x", max_age_s=0.15)


def _observer(attacker: Attacker) -> None:
    attacker.hello("observer")
    attacker.beat(offset_ns=3600 * 1000 * MS)
    attacker.move()
    _asks(attacker)


def _lies_about_the_clock(attacker: Attacker) -> None:
    attacker.beat(offset_ns=3600 * 1000 * MS)


STEPS: dict[str, Callable[[Attacker], None]] = {
    "motion": _second_operator,
    "hello, then motion": _refused_operator,
    "motion far ahead": _far_ahead,
    "requests": _asks,
    "requests but a stop": _clone_asks,
    "looks on": _observer,
    "heartbeats": _lies_about_the_clock,
    "estop": lambda attacker: attacker.ask("estop"),
    "small": lambda attacker: attacker.flood("small"),
    "largest": lambda attacker: attacker.flood("largest"),
}
"""What an attacker may do, by name; one call is one step."""


def attack(attacker: Attacker, what: str) -> Iterator[None]:
    """Listen, and then do it, step by step, for as long as the caller asks."""
    while True:
        with suppress(BadPacket):  # the other side may answer as it likes
            attacker.listen()
        STEPS[what](attacker)
        yield
