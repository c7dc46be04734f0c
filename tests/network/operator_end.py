"""The operator's end of a link under test: beats, accepts touch, and keeps what it accepted, until its input ends.

    operator_end.py ADDRESS BASE_PORT KEYS REMOTE_PUBLIC_KEY [twice]

With `twice` it has two connections for touch. It prints how many packets it has accepted, about every hundred, and at
the end all that the test judges. It sends the age of
each accepted packet, and offset and uncertainty of the remote machine's clock, ns, to the UDP port AGES of its host,
where a picture's end may listen.
"""

import json
import select
import socket
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common.limits import AGE_DEFAULT_S
from common.link.clock_offset import ClockOffset
from common.link.keys import load_keys
from common.link.link import OperatorLink
from common.link.packet_filter import PacketFilter
from common.runtime.periodic_loop import PeriodicLoop
from common.runtime.scheduling import become_timely
from common.wire.messages import Touch
from common.wire.packets import LinkState
from common.wire.session_messages import Heartbeat
from common.wire.streams import STREAMS
from tests.network.remote_end import CLOCK_APART_NS

SESSION = 1
EVERY = 100
AGES = 5650


@dataclass(slots=True)
class OperatorEnd:
    """Judges touch packets as the operator site does."""

    link: OperatorLink
    clock: ClockOffset = field(default_factory=ClockOffset)
    acceptance: PacketFilter = field(default_factory=lambda: PacketFilter(max_age_ns=round(AGE_DEFAULT_S * 1e9)))
    accepted: list[tuple[int, int, int, int, int, int]] = field(default_factory=list)
    """Of each accepted packet: when, sequence, source time, age, offset and uncertainty of the clocks; times in ns."""
    _beats: int = 0
    _beat_ns: int = 0

    def step(self, now_ns: int) -> bool:
        """Take what came; whether a touch packet was accepted."""
        for packet in self.link.receive("heartbeat"):
            beat = Heartbeat.decode(packet)
            self.clock.add(beat.sent_ns, beat.arrived_ns, beat.time_ns, now_ns)
        if now_ns - self._beat_ns >= 1e9 / STREAMS["heartbeat"].rate_hz:
            self._beat_ns = now_ns
            self._beats += 1
            known = (self.clock.offset_ns, self.clock.uncertainty_ns or 0)
            ask = Heartbeat(SESSION, self._beats, now_ns, LinkState.ENGAGED, now_ns, 0, *known)
            self.link.send("heartbeat", ask.encode())
        return sum(self._touch(packet, now_ns) for packet in self.link.newest("touch")) > 0

    def _touch(self, packet: bytes, now_ns: int) -> bool:
        touch = Touch.decode(packet)
        offset_ns, uncertainty_ns = self.clock.offset_ns, self.clock.uncertainty_ns
        if not self.acceptance.accept(touch, SESSION, now_ns, offset_ns, uncertainty_ns) or uncertainty_ns is None:
            return False
        age_ns = self.acceptance.age_ns
        self.accepted.append((now_ns, touch.sequence, touch.time_ns, age_ns, offset_ns, uncertainty_ns))
        return True

    def report(self) -> dict[str, Any]:
        """All that the test judges."""
        return {"accepted": self.accepted, "refused": self.acceptance.refused, "max_age_ns": self.acceptance.max_age_ns}


def run(end: OperatorEnd, stop: Callable[[], bool]) -> None:
    """Step at the site's rate until `stop()`."""
    become_timely()
    printed = 0
    loop = PeriodicLoop(1.0 / STREAMS["motion"].rate_hz)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ages:
        while not stop():
            loop.wait()
            if end.step(time.monotonic_ns()):
                with suppress(OSError):  # nobody listens
                    known = end.acceptance.age_ns, end.clock.offset_ns - CLOCK_APART_NS, end.clock.uncertainty_ns
                    ages.sendto(json.dumps(known).encode(), ("127.0.0.1", AGES))
                if len(end.accepted) >= printed + EVERY:
                    printed = len(end.accepted)
                    print(len(end.accepted), flush=True)


def main(address: str, base_port: int, keys: Path, remote_public_key: str, twice: bool) -> None:
    """Run until the input ends."""
    with OperatorLink(address, base_port, load_keys(keys), remote_public_key) as link:
        link.double(twice)
        end = OperatorEnd(link)
        run(end, lambda: bool(select.select([sys.stdin], [], [], 0.0)[0]))
    print(json.dumps(end.report()), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4], sys.argv[5:] == ["twice"])
