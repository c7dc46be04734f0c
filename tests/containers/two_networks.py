"""The remote site's host and the operator's in containers, each in its network, and the router between them."""

import json
import subprocess
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.containers.checkout import Checkout, run
from tests.network.two_hosts import Host, Passed
from tests.places import ROOT

HOSTS = ROOT / "tests" / "containers" / "hosts"


@dataclass
class TwoNetworks:
    """Both hosts; the router forwards from each network through a queue of its own."""

    remote: Checkout
    operator: Checkout
    router: str
    real_time: bool
    """Whether this engine may let containers' threads come first."""
    ends: ExitStack
    ways: tuple[Host, ...] = ()

    def address(self, name: str, container: str) -> str:
        """Of a container in the network of this name."""
        network = f"{self.remote.environment['NETWORKS']}-{name}"
        found = json.loads(run("docker", "inspect", container))[0]["NetworkSettings"]["Networks"]
        return str(found[network]["IPAddress"])

    def connect(self) -> None:
        """Set the route through the router on both hosts, which have their networks by now."""
        hosts = {"remote": self.remote, "operator": self.operator}
        addresses = {name: self.address(name, host.container("host")) for name, host in hosts.items()}
        for (name, host), far in zip(hosts.items(), reversed(addresses.values()), strict=True):
            inside = ("nsenter", "--target", host.inspect("host", ".State.Pid"), "--net")
            run(*inside, "ip", "route", "replace", f"{far}/32", "via", self.address(name, self.router))
        pid = int(run("docker", "inspect", "-f", "{{.State.Pid}}", self.router))
        arriving = [("FORWARD", "-s", address) for address in addresses.values()]
        self.ways = tuple(Host(self.ends, pid, match, queue) for queue, match in enumerate(arriving, 1))

    def impair(self, delay_ms: float, jitter_ms: float, loss: float) -> list[Passed]:
        """Impair each direction by itself; the numbers of what came so far are of each."""
        return [way.impair(delay_ms, jitter_ms, loss) for way in self.ways]

    def cut(self) -> None:
        """Drop every packet from now on, without notice."""
        for way in self.ways:
            way.cut()

    def heal(self) -> None:
        """Take back what `cut` did."""
        for way in self.ways:
            way.heal()


@contextmanager
def two_networks(folder: Path) -> Iterator[TwoNetworks]:
    """Two hosts with nothing on them yet, and take everything down again."""
    name = f"teletaction-{uuid.uuid4().hex[:8]}"
    with ExitStack() as ends:
        wires = Checkout(folder / "router", COMPOSE_FILE=str(HOSTS / "network.yml"), NETWORKS=name)
        remote, operator = (
            Checkout(folder / host, HOSTS / f"{host}.yml", COMPOSE_PROFILES=host, NETWORKS=name)
            for host in ("remote", "operator")
        )
        remote("docker-compose build", seconds=400.0)  # the router is of the same image
        for host in (wires, remote, operator):
            ends.callback(host.remove)
        wires("docker-compose up --detach")
        real_time = may_raise_limits()
        if not real_time:
            for host in (remote, operator):
                host.environment["REAL_TIME_PRIORITY"] = "0"
        yield TwoNetworks(remote, operator, wires.container("router"), real_time, ends)


def may_raise_limits() -> bool:
    """Whether the engine starts a container with a higher limit than it has; one that stands in a container may not."""
    command = ("docker", "run", "--rm", "--network", "none", "--ulimit", "rtprio=10", "teletaction", "true")
    tried = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert tried.returncode == 0 or "setting rlimit" in tried.stderr, tried.stderr
    return tried.returncode == 0
