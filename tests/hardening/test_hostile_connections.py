"""Ten thousand connections of those who do not belong, while a session runs: nothing but counters changes."""

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import numpy as np
import pytest

from common.capabilities import capabilities
from common.keys import TrustedKeys, load_keys
from common.link import OperatorLink, RemoteLink
from common.loop import PeriodicLoop
from common.messages import TOUCH_BLOCK, TOUCH_FIELDS, Touch
from operator_site.session_client import SessionClient
from remote_site.session_server import SessionServer
from tests.hardening.own_memory import own_resident_bytes

pytestmark = [pytest.mark.hardening, pytest.mark.timeout(300)]

ATTACK = Path(__file__).parent / "attack.py"
KINDS = ("wrong_key", "no_key", "garbage", "huge_frame", "broken_handshake", "slow")
COUNT = 1700
"""Of each kind: more than ten thousand in all."""
FULL_HANDSHAKES = ("wrong_key",)
TOUCH_NOTHING = TOUCH_BLOCK.to_bytes(np.zeros((5, len(TOUCH_FIELDS)), np.float32))
AT_REST = np.zeros((5, 3), np.float32)
MOST_GROWTH_MIB = 8.0


class Keys(Protocol):
    remote: Path
    operator: Path


class Served:
    """Both ends of a session in one loop at 500 Hz."""

    def __init__(self, keys: Keys, base_port: int) -> None:
        remote = load_keys(keys.remote)
        self.remote_link = RemoteLink("127.0.0.1", base_port, remote, TrustedKeys(keys.remote))
        self.operator_link = OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), remote.public)
        able = capabilities(("index",), 500.0)
        self.server = SessionServer(self.remote_link, able, 0.15)
        self.client = SessionClient(self.operator_link, able, 0.15, want_engaged=True)
        self.server_key = remote.public
        self.longest_gap_ns = 0
        self._sequence = 0

    def turn(self) -> None:
        now_ns = time.monotonic_ns()
        self.server.step(now_ns, "")
        session = self.server.session
        if session.ident:
            self._sequence += 1
            touch = Touch(session.ident, self._sequence, now_ns, session.state, TOUCH_NOTHING, ("",) * 5, ())
            self.remote_link.send_latest("touch", touch.encode())
        now_ns = time.monotonic_ns()  # one time a tick of the operator's site, for what it takes and what it sends
        self.client.step(now_ns, "")
        self.client.send_motion(now_ns, AT_REST)
        self.longest_gap_ns = max(self.longest_gap_ns, self.client.acceptance.gap_ns(now_ns) or 0)

    def run(self, until: "subprocess.Popen[bytes] | None", seconds: float) -> PeriodicLoop:
        """Turn until a process has ended, or for some time."""
        loop, end_s = PeriodicLoop(0.002), time.monotonic() + seconds
        while (until.poll() is None) if until is not None else time.monotonic() < end_s:
            loop.wait()
            self.turn()
        return loop

    def works_on(self) -> None:
        """Engaged, with another hundred motion packets accepted; a stall of the machine may come between."""
        enough, end_s = self.server.acceptance.received + 100, time.monotonic() + 10.0
        while not (self.engaged and self.server.acceptance.received > enough):
            assert time.monotonic() < end_s, self.server.acceptance
            self.run(None, 0.05)

    @property
    def engaged(self) -> bool:
        return self.server.both_engaged and self.client.both_engaged


@pytest.fixture
def served(keys: Keys, base_port: int) -> Iterator[Served]:
    made = Served(keys, base_port)
    end_s = time.monotonic() + 10.0
    while not made.engaged:
        assert time.monotonic() < end_s
        made.turn()
        time.sleep(0.001)
    yield made
    made.operator_link.close()
    made.remote_link.close()


@pytest.mark.parametrize("kind", KINDS)
def test_hostile_connections_change_nothing_but_counters(served: Served, base_port: int, kind: str) -> None:
    served.run(None, 1.0)

    def attack(count: int) -> PeriodicLoop:
        command = [sys.executable, str(ATTACK), kind, str(count), str(base_port), served.server_key]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
            try:
                return served.run(process, 0.0)
            finally:
                process.kill()  # an attacker that hangs must not hang the test

    attack(COUNT // 10)  # buffers and threads have their size after these
    before_bytes, ident = own_resident_bytes(), served.server.session.ident
    loop = attack(COUNT)
    grown_mib = (own_resident_bytes() - before_bytes) / 2**20
    print(
        f"{kind}: {loop.ticks} ticks, late {loop.late_us(0.5):.0f} us median, {loop.late_us(0.99):.0f} us p99; "
        f"handshakes {dict(served.remote_link.handshakes)}; {grown_mib:+.1f} MiB; "
        f"longest gap {served.longest_gap_ns / 1e6:.0f} ms"
    )
    assert grown_mib < MOST_GROWTH_MIB
    assert not served.server.damaged
    assert not served.client.damaged
    assert served.remote_link.handshakes["admitted"] == 4
    refused = served.remote_link.handshakes["refused"]
    assert refused >= COUNT + COUNT // 10 if kind in FULL_HANDSHAKES else refused == 0  # some knock twice
    served.works_on()
    assert served.server.session.ident == ident, "the session is still the same"
    happened = {h.what for h in served.server.session.take_happenings() + served.client.session.take_happenings()}
    assert happened <= {"connected", "engaged", "silent", "heard"}, "nothing but a gap of a busy machine"
