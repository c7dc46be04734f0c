"""A real session with an outlet for each tool: their readers receive what the operator site recorded meanwhile."""

import re
import signal
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
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
"""Share of the recorded messages that arrive or are counted as dropped: a busy machine may lose some of the feed."""
SIGNALS = dict(zip(TOOLS, (signal.SIGTERM, signal.SIGINT, signal.SIGTERM), strict=True))
EDGE_NS = 5_000_000
"""Greatest difference between a message's times at a reader and in the recording, ns: each reads the clocks once."""


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


def counted(log: str) -> tuple[int, int, int]:
    """Messages that an outlet has sent, dropped, and could not read, by the last line of its log."""
    found = re.search(r"sent (\d+) messages; (\d+) dropped because the tool was behind, (\d+) unreadable\n$", log)
    assert found, log
    return int(found[1]), int(found[2]), int(found[3])


def recorded(path: Path, topic: str, *, wall_clock: bool) -> np.ndarray:
    """Times of the site's messages, ns."""
    with path.open("rb") as file:
        messages = NamedRecording(path, file).messages([topic])
        return np.array([each.wall_ns if wall_clock else each.monotonic_ns for each in messages])


@pytest.mark.parametrize("to", TOOLS)
def test_a_reader_receives_what_the_site_recorded(to: str, ended: tuple) -> None:
    path, received, logs = ended
    _, dropped, _ = counted(logs[to])
    for topic, count in received[to].counts.items():
        sent_ns = recorded(path, topic, wall_clock=to != "lsl")
        came_ns = np.array(received[to].times_ns[topic])
        apart_ns = np.abs(sent_ns[:, None] - came_ns)
        first, last = apart_ns[:, [0, -1]].argmin(axis=0)
        fed = int(last - first + 1)
        print(f"{to}: {count} of {fed} {topic}, times within {apart_ns.min(axis=0).max() * 1e-6:.3f} ms")
        assert apart_ns.min(axis=0).max() < EDGE_NS
        assert LEAST * fed - dropped <= count <= fed
    assert received[to].counts["operator/rendered"] >= SEEN["operator/rendered"]


@pytest.mark.parametrize("to", TOOLS)
def test_an_outlet_ends_on_a_signal_and_counts(to: str, ended: tuple) -> None:
    _, received, logs = ended
    sent, _, unreadable = counted(logs[to])
    assert sent >= sum(received[to].counts.values())
    assert unreadable == 0
    assert "Traceback" not in logs[to]
