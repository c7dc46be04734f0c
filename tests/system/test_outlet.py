"""A real session with an outlet for each tool: their readers receive what the operator site recorded meanwhile."""

import re
import signal
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import pytest

from robustness.fault_session import read_figures
from teletaction.export.named_recording import NamedRecording
from teletaction.outlets.outlet import TOOLS
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.unit.teletaction.outlets.readers import Received, connected, lsl_on_this_machine
from tests.waiting import wait_until

pytestmark = [pytest.mark.exports, pytest.mark.timeout(180)]

PATIENCE_S = 40.0
SEEN = {"operator/rendered": 1000, "operator/clock": 30, "operator/figures": 2}
"""Messages that each reader waits for."""
LEAST = 0.9
"""Share of the recorded messages that a reader receives at least: a busy machine may lose some of the feed."""
SIGNALS = dict(zip(TOOLS, (signal.SIGTERM, signal.SIGINT, signal.SIGTERM), strict=True))
EDGE_NS = 1_000_000
"""Greatest difference of two pairs of readings of the same clocks, ns."""


@dataclass
class Outlet:
    """An outlet's process."""

    to: str
    processes: SessionProcesses

    @property
    def log(self) -> str:
        return (self.processes.out / "outlet.log").read_text("utf-8")

    @property
    def address(self) -> str:
        """Where its clients find it, once it has said so."""
        wait_until(lambda: "reads the feed" in self.log, lambda: self.log, PATIENCE_S)
        found = re.search(rf"{self.to}: (\S+);", self.log)
        assert found, self.log
        return found[1]

    def close(self) -> None:
        """End it as its tool's signal does."""
        process = self.processes.running["outlet"]
        process.send_signal(SIGNALS[self.to])
        assert process.wait(10.0) == 0, self.log


@pytest.fixture(scope="module")
def ended(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Received], dict[str, str]]:
    """The operator site's recording, what each tool's reader received, and the log of each outlet."""
    out = tmp_path_factory.mktemp("session")
    configurations = prepare(DemoOptions(seconds=600.0, fingers=1), out)
    sites = SessionProcesses(out)
    outlets = {}
    with ExitStack() as opened:
        opened.enter_context(lsl_on_this_machine(out))
        opened.callback(sites.end)
        for name, configuration in configurations.items():
            sites.start(name, configuration)
        wait_until(lambda: read_figures(out, "operator").get("state") == "engaged", sites.ended, PATIENCE_S)
        for to, tool in TOOLS.items():
            folder = out / to
            folder.mkdir()
            outlets[to] = Outlet(to, SessionProcesses(folder))
            opened.callback(outlets[to].processes.end)
            options = ("--open-to-network",) if tool.port is None else ("--port", "0")
            outlets[to].processes.start("outlet", configurations["operator"], "--to", to, *options)
        readers = {to: opened.enter_context(connected(to, outlets[to].address, out / to)) for to in TOOLS}
        for reader in readers.values():
            reader.until(SEEN)
        received = {to: reader.finish(SEEN, outlets[to]) for to, reader in readers.items()}
    return out / "operator.mcap", received, {to: outlet.log for to, outlet in outlets.items()}


def recorded(path: Path, topic: str, times_ns: list[int], *, wall_clock: bool) -> int:
    """Number of the site's messages from the first to the last received one."""
    first_ns, last_ns = min(times_ns) - EDGE_NS, max(times_ns) + EDGE_NS
    with path.open("rb") as file:
        messages = NamedRecording(path, file).messages([topic])
        return sum(first_ns <= (each.wall_ns if wall_clock else each.monotonic_ns) <= last_ns for each in messages)


@pytest.mark.parametrize("to", TOOLS)
def test_a_reader_receives_what_the_site_recorded(to: str, ended: tuple) -> None:
    path, received, _ = ended
    for topic, count in received[to].counts.items():
        fed = recorded(path, topic, received[to].times_ns[topic], wall_clock=to != "lsl")
        print(f"{to}: {count} of {fed} {topic}")
        assert LEAST * fed <= count <= fed
    assert received[to].counts["operator/rendered"] >= SEEN["operator/rendered"]


@pytest.mark.parametrize("to", TOOLS)
def test_an_outlet_ends_on_a_signal_and_counts(to: str, ended: tuple) -> None:
    _, received, logs = ended
    found = re.search(r"sent (\d+) messages; (\d+) dropped because the tool was behind, (\d+) unreadable\n$", logs[to])
    assert found, logs[to]
    assert int(found[1]) >= sum(received[to].counts.values())
    assert found.group(2, 3) == ("0", "0")
    assert "Traceback" not in logs[to]
