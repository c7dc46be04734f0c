"""Both ends of the real link in two processes, with packets between them that are really delayed, lost and cut off."""

import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from random import Random

import numpy as np
import pytest

from common.wire.streams import STREAMS
from sim_sensors.network.conditions import Conditions
from sim_sensors.network.path import NetworkPath
from sim_sensors.network.stream import TcpStream
from tests.conftest import Keys
from tests.network.link_bench import MEASURED, Bench, assert_sound
from tests.network.two_hosts import Program, namespace_of
from tests.waiting import wait_until

pytestmark = [pytest.mark.netns, pytest.mark.timeout(180)]

PARTITION_S = 2.0


@pytest.fixture
def bench(keys: Keys) -> Iterator[Bench]:
    with ExitStack() as ends:
        yield Bench(keys, ends)


@pytest.mark.parametrize(
    ("delay_ms", "jitter_ms", "loss"),
    [(0.0, 0.0, 0.0), (20.0, 2.0, 0.0), (20.0, 2.0, 0.01), (20.0, 2.0, 0.05)],
    ids=["unimpaired", "20+-2ms", "20+-2ms,1%", "20+-2ms,5%"],
)
def test_packets_accepted_over_an_impaired_network_are_young_and_in_order(
    bench: Bench, link_table: list[str], delay_ms: float, jitter_ms: float, loss: float
) -> None:
    if delay_ms:
        bench.hosts.impair(delay_ms, jitter_ms, loss)
    bench.connect()
    bench.accept(MEASURED)
    packets = bench.hosts.impair(delay_ms, jitter_ms, loss) if delay_ms else None
    measured = bench.finish()
    link_table.append(measured.row(f"{delay_ms:g} +- {jitter_ms:g} ms, loss {loss:.0%}"))
    assert_sound(measured)
    assert np.median(measured.true_age_ns) >= (delay_ms - jitter_ms) * 1e6, "the packets were not delayed"
    if packets is not None:
        share = packets.dropped / (packets.passed + packets.dropped)
        assert loss / 2 <= share <= 2 * loss, "the packets were not lost as asked"


@pytest.mark.parametrize("delay_ms", [20.0, 40.0])
def test_a_lost_packet_holds_the_link_as_long_as_in_the_simulated_network(bench: Bench, delay_ms: float) -> None:
    conditions, period_s = Conditions(delay_ms * 1e-3, loss=0.01), 1.0 / STREAMS["touch"].rate_hz
    simulated = TcpStream(NetworkPath(lambda _: conditions), Random(1))
    arrived_ms = []
    for sent_s in period_s * np.arange(10 * MEASURED):
        simulated.push(b"touch", sent_s)
        if simulated.take(sent_s):
            arrived_ms.append(1e3 * sent_s)
    bench.hosts.impair(delay_ms, 0.0, 0.0)
    bench.connect()
    bench.hosts.impair(delay_ms, 0.0, conditions.loss)
    bench.accept(2 * MEASURED)
    held_ms, simulated_ms = (
        np.median(gaps_ms[gaps_ms > delay_ms])
        for gaps_ms in (np.diff(bench.finish().arrived_ns) / 1e6, np.diff(arrived_ms))
    )
    assert held_ms == pytest.approx(simulated_ms, rel=0.15)


def test_a_second_connection_brings_most_packets_that_a_lost_one_holds_back(
    bench: Bench, link_table: list[str]
) -> None:
    gaps_ms = {}
    for twice in (False, True):
        bench.hosts.impair(50.0, 0.0, 0.0)
        bench.connect(twice=twice)
        bench.hosts.impair(50.0, 0.0, 0.01)
        bench.accept(MEASURED)
        measured = bench.finish()
        link_table.append(measured.row(f"50 ms, loss 1%, {1 + twice} connection" + "s" * twice))
        assert_sound(measured)
        gaps_ms[twice] = np.percentile(np.diff(measured.arrived_ns) / 1e6, 99)
    assert gaps_ms[True] < 0.5 * gaps_ms[False]


@pytest.mark.parametrize(
    ("to_remote", "to_operator"),
    [(True, True), (True, False), (False, True)],
    ids=["partition", "nothing to remote", "nothing to operator"],
)
def test_nothing_passes_a_cut_network_and_after_healing_packets_are_accepted_again(
    bench: Bench, link_table: list[str], to_remote: bool, to_operator: bool
) -> None:
    hosts = bench.hosts
    cut = (hosts.remote,) * to_remote + (hosts.operator,) * to_operator
    hosts.impair(20.0, 2.0, 0.0)
    bench.connect()
    bench.accept(500)
    cut_ns = time.monotonic_ns()
    for host in cut:
        host.cut()
    cut_done_ns = time.monotonic_ns()
    time.sleep(PARTITION_S)
    heal_ns = time.monotonic_ns()
    for host in cut:
        host.heal()
    bench.accept(1000)
    measured = bench.finish()
    ways = "both ways" if to_remote and to_operator else "to the remote" if to_remote else "to the operator"
    back_ns = measured.arrived_ns[measured.arrived_ns > heal_ns][0]
    silent_ns = measured.arrived_ns[measured.arrived_ns <= heal_ns][-1]
    row = measured.row(f"20 +- 2 ms, cut {ways} {PARTITION_S:g} s")
    last_ms, again_ms = (silent_ns - cut_ns) / 1e6, (back_ns - heal_ns) / 1e6
    link_table.append(f"{row}, last accepted {last_ms:.0f} ms after the cut, again {again_ms:.0f} ms after healing")
    assert_sound(measured)
    if to_operator:
        during = (measured.source_ns > cut_done_ns) & (measured.arrived_ns < heal_ns)
        assert not during.any(), "a packet passed a cut network"
    assert (measured.source_ns > heal_ns).sum() >= 500, "what was made after healing was not accepted"


def fail_in_the_middle(keys: Keys, made: set[str]) -> None:
    with ExitStack() as ends:
        bench = Bench(keys, ends)
        bench.hosts.impair(20.0, 2.0, 0.05)
        bench.connect()
        bench.hosts.remote.cut()
        made |= {bench.hosts.remote.namespace, bench.hosts.operator.namespace}
        assert made <= namespaces()
        raise ZeroDivisionError


def test_nothing_stays_behind_when_a_test_fails(keys: Keys) -> None:
    made: set[str] = set()
    with pytest.raises(ZeroDivisionError):
        fail_in_the_middle(keys, made)
    assert len(made) == 2
    assert not made & namespaces()


def test_nothing_stays_behind_when_the_tests_are_killed() -> None:
    script = (
        "from tests.network.two_hosts import two_hosts\n"
        "with two_hosts() as hosts:\n"
        "    hosts.impair(20.0, 2.0, 0.05)\n"
        "    print(hosts.remote.namespace, hosts.operator.namespace, flush=True)\n"
        "    input()\n"
    )
    with Program(sys.executable, "-c", script) as killed:
        made = set(killed.hear().split())
        assert len(made & namespaces()) == 2
        os.kill(killed.pid, signal.SIGKILL)
    wait_until(lambda: not made & namespaces(), "a namespace has outlived the tests", 20.0)


def namespaces() -> set[str]:
    """All network namespaces in which a process lives."""
    found = set()
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has just ended
            found.add(namespace_of(process.name))
    return found
