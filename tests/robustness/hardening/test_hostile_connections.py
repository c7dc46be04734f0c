"""Ten thousand connections of strangers during a session change only counters."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from common.runtime.periodic_loop import PeriodicLoop
from tests.robustness.hardening.own_memory import own_resident_bytes
from tests.robustness.hardening.served import Keys, Served
from tests.waiting import wait_until

pytestmark = [pytest.mark.hardening, pytest.mark.timeout(300)]

ATTACK = Path(__file__).parent / "attack.py"
KINDS = ("wrong_key", "no_key", "garbage", "huge_frame", "broken_handshake", "slow")
COUNT = 1700
"""Of each kind: more than ten thousand in all."""
FULL_HANDSHAKES = ("wrong_key",)
MOST_GROWTH_MIB = 8.0


@pytest.fixture
def served(keys: Keys, base_port: int) -> Iterator[Served]:
    made = Served(keys, base_port)
    wait_until(lambda: made.engaged or made.turn(), "the session does not engage", every_s=0.001)
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
