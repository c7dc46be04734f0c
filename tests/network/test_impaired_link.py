"""Both ends of the real link in two processes, with packets between them that are really delayed, lost and cut off."""

import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from common.config.file import to_toml
from common.config.link_models import RendezvousConfig, TunnelConfig
from common.limits import GAP_S
from common.link.keys import load_keys
from common.link.packet_filter import FUTURE_TOLERANCE_NS
from teletaction.tunnel.room_secret import create_secret
from tests.conftest import Keys
from tests.network.operator_end import EVERY
from tests.network.remote_end import CLOCK_APART_NS
from tests.network.two_hosts import OPERATOR, REMOTE, Program, TwoHosts, namespace_of, two_hosts, why_not
from tests.waiting import wait_until

pytestmark = [pytest.mark.netns, pytest.mark.timeout(180)]

BASE_PORT, RENDEZVOUS_PORT = 5600, 5640
MEASURED = 2500
"""Packets accepted in each measurement: 5 s of an undisturbed link."""
PARTITION_S = 2.0


@dataclass(frozen=True)
class Measured:
    """What the operator's end accepted, in order; times in ns of its clock."""

    sent: int
    arrived_ns: np.ndarray
    sequence: np.ndarray
    source_ns: np.ndarray
    age_ns: np.ndarray
    """As the operator's end knew it."""
    true_age_ns: np.ndarray
    """As this test knows it, which knows both clocks."""
    uncertainty_ns: np.ndarray
    max_age_ns: int
    refused: dict[str, int]

    def row(self, name: str) -> str:
        """One line of the table: ages and gaps in ms, at the median, at 99 %, and the largest."""
        gaps_ns = np.diff(self.arrived_ns)
        numbers = (
            f"{np.percentile(values, 50) / 1e6:8.2f} {np.percentile(values, 99) / 1e6:8.2f} {values.max() / 1e6:8.2f}"
            for values in (self.age_ns, gaps_ns)
        )
        share, too_long = f"{len(self.sequence) / self.sent:6.1%}", int((gaps_ns > GAP_S * 1e9).sum())
        return f"{name:34} {share} {' '.join(numbers)} {too_long:8d}  {self.refused}"


HEAD = f"{'link':34} accept" + "".join(
    f" {name:>8}" for name in ("age p50", "p99", "max", "gap p50", "p99", "max", "too long", "refused")
)


class Bench:
    """The two hosts with an end of the link on each."""

    def __init__(self, keys: Keys, ends: ExitStack) -> None:
        self.hosts: TwoHosts = ends.enter_context(two_hosts())
        self._keys = keys
        self._counted = 0

    def connect(self, address: str = REMOTE) -> None:
        """Start both ends and wait until packets are accepted; the remote site is at `address` for both."""
        end = (sys.executable, "-m")
        self.remote = self.hosts.remote.start(
            *end, "tests.network.remote_end", address, str(BASE_PORT), str(self._keys.remote)
        )
        assert self.remote.hear() == "bound"
        public = load_keys(self._keys.remote).public
        self.operator: Program = self.hosts.operator.start(
            *end, "tests.network.operator_end", address, str(BASE_PORT), str(self._keys.operator), public
        )
        self.accept(EVERY)

    def tunnel(self, folder: Path) -> None:
        """Let the remote host connect only outwards, and only to a rendezvous; run that one at the operator's host."""
        fire = ("iptables", "-I")
        self.hosts.remote.run(*fire, "INPUT", "-i", "cable", "-p", "tcp", "--syn", "-j", "DROP")
        other = ("-p", "tcp", "--syn", "!", "--dport", str(RENDEZVOUS_PORT))
        self.hosts.remote.run(*fire, "OUTPUT", "-o", "cable", *other, "-j", "DROP")
        create_secret(folder / "secret")
        room = {"host": OPERATOR, "port": RENDEZVOUS_PORT, "room": "ward-3", "secret": folder / "secret"}
        parts = (
            (self.hosts.operator, "rendezvous", RendezvousConfig(bind=OPERATOR, rooms={"ward-3": folder / "secret"})),
            (self.hosts.remote, "tunnel", TunnelConfig.model_validate(room | {"side": "remote"})),
            (self.hosts.operator, "tunnel", TunnelConfig.model_validate(room | {"side": "operator"})),
        )
        for number, (host, name, config) in enumerate(parts):
            file = folder / f"{number}.toml"
            file.write_text(to_toml(config))
            run = (sys.executable, "-m", "tests.network.host_process", "0", "0")
            host.start(*run, name, "--config", str(file)).hear()

    def accept(self, packets: int) -> None:
        """Wait until this number of further packets was accepted."""
        wanted = self._counted + packets
        while self._counted < wanted:
            self._counted = int(self.operator.hear())

    def finish(self) -> Measured:
        """End both ends and read what they found."""
        report: dict[str, Any] = json.loads(self.operator.end().splitlines()[-1])
        sent = json.loads(self.remote.end())["sent"]
        arrived, sequence, source, age, offset, uncertainty = np.array(report["accepted"], dtype=np.int64).T
        assert (np.abs(offset - CLOCK_APART_NS) <= uncertainty).all(), "the clocks are not where they were found to be"
        true_age = arrived - (source - CLOCK_APART_NS)
        source_ns = source - CLOCK_APART_NS
        return Measured(
            sent, arrived, sequence, source_ns, age, true_age, uncertainty, report["max_age_ns"], report["refused"]
        )


@pytest.fixture(scope="module", autouse=True)
def possible() -> None:
    """Skip where it cannot be done."""
    reason = why_not()
    if reason:
        pytest.skip(reason)


@pytest.fixture(scope="module")
def table() -> Iterator[list[str]]:
    """Rows of all links, printed at the end."""
    rows: list[str] = []
    yield rows
    print("\n".join((HEAD, *rows)))


@pytest.fixture
def bench(keys: Keys) -> Iterator[Bench]:
    with ExitStack() as ends:
        yield Bench(keys, ends)


def assert_sound(measured: Measured) -> None:
    """What holds on any network: nothing old, nothing twice, nothing backwards, nothing from the future."""
    assert (measured.age_ns <= measured.max_age_ns).all()
    assert (measured.true_age_ns <= measured.max_age_ns + measured.uncertainty_ns).all()
    assert (measured.true_age_ns >= -(FUTURE_TOLERANCE_NS + 2 * measured.uncertainty_ns)).all()
    assert (np.diff(measured.sequence) > 0).all()
    assert (np.diff(measured.source_ns) > 0).all()
    assert len(measured.sequence) <= measured.sent


@pytest.mark.parametrize(
    ("delay_ms", "jitter_ms", "loss"),
    [(0.0, 0.0, 0.0), (20.0, 2.0, 0.0), (20.0, 2.0, 0.01), (20.0, 2.0, 0.05)],
    ids=["unimpaired", "20+-2ms", "20+-2ms,1%", "20+-2ms,5%"],
)
def test_packets_accepted_over_an_impaired_network_are_young_and_in_order(
    bench: Bench, table: list[str], delay_ms: float, jitter_ms: float, loss: float
) -> None:
    if delay_ms:
        bench.hosts.impair(delay_ms, jitter_ms, loss)
    bench.connect()
    bench.accept(MEASURED)
    packets = bench.hosts.impair(delay_ms, jitter_ms, loss) if delay_ms else None
    measured = bench.finish()
    table.append(measured.row(f"{delay_ms:g} +- {jitter_ms:g} ms, loss {loss:.0%}"))
    assert_sound(measured)
    assert np.median(measured.true_age_ns) >= (delay_ms - jitter_ms) * 1e6, "the packets were not delayed"
    if packets is not None:
        share = packets.dropped / (packets.passed + packets.dropped)
        assert loss / 2 <= share <= 2 * loss, "the packets were not lost as asked"


@pytest.mark.parametrize("delay_ms", [0.0, 20.0])
def test_a_remote_site_with_one_outbound_port_is_reached_over_a_rendezvous(
    bench: Bench, table: list[str], tmp_path: Path, delay_ms: float
) -> None:
    if delay_ms:
        bench.hosts.impair(delay_ms, 0.1 * delay_ms, 0.01)
    bench.tunnel(tmp_path)
    bench.connect("127.0.0.1")
    bench.accept(MEASURED)
    measured = bench.finish()
    table.append(measured.row(f"over a rendezvous, {delay_ms:g} ms{', loss 1%' * bool(delay_ms)}"))
    assert_sound(measured)
    assert np.median(measured.true_age_ns) >= 0.9e6 * delay_ms


@pytest.mark.parametrize(
    ("to_remote", "to_operator"),
    [(True, True), (True, False), (False, True)],
    ids=["partition", "nothing to remote", "nothing to operator"],
)
def test_nothing_passes_a_cut_network_and_after_healing_packets_are_accepted_again(
    bench: Bench, table: list[str], to_remote: bool, to_operator: bool
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
    table.append(f"{row}, last accepted {last_ms:.0f} ms after the cut, again {again_ms:.0f} ms after healing")
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
