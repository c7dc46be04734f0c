"""After SIGTERM every process ends within 2 s, with exit code 0 and its recording closed, whatever is missing."""

import contextlib
import json
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from mcap.reader import make_reader

from common.config.file import load_config, to_toml
from common.config.site_models import OperatorConfig
from teletaction.session.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.waiting import wait_until

pytestmark = [pytest.mark.session, pytest.mark.timeout(90)]

END_S = 2.0
PATIENCE_S = 40.0


@pytest.fixture
def session(tmp_path: Path) -> Iterator[tuple[SessionProcesses, dict[str, Path]]]:
    """Nothing is running yet; what is started is ended with the test."""
    processes = SessionProcesses(tmp_path)
    try:
        yield processes, prepare(DemoOptions(fingers=1), tmp_path)
    finally:
        processes.end()


def state(processes: SessionProcesses, name: str) -> str:
    try:
        status = json.loads((processes.out / f"{name}.json").read_text("utf-8"))
    except FileNotFoundError:
        return ""
    return str(status.get("state", "running"))


def end(process: "subprocess.Popen[bytes]") -> int:
    process.send_signal(signal.SIGTERM)
    return process.wait(END_S)


def assert_closed(recording: Path) -> None:
    """A recording that was closed has its index, with every message counted."""
    with recording.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count > 0


def test_a_working_session_ends_in_time(session: tuple[SessionProcesses, dict[str, Path]]) -> None:
    processes, configurations = session
    for name in PROCESSES:
        processes.start(name, configurations[name])
    wait_until(lambda: state(processes, "operator") == "engaged", "the session did not engage", PATIENCE_S)
    asked_s = time.monotonic()
    assert processes.end() == []
    assert time.monotonic() - asked_s <= END_S
    assert processes.ended() == dict.fromkeys(PROCESSES, 0)
    for name in PROCESSES:
        assert_closed(processes.out / f"{name}.mcap")


@pytest.mark.parametrize(("site", "simulation"), [("remote", "sim-remote"), ("operator", "sim-operator")])
def test_a_site_without_peer_and_devices_ends_in_time(
    session: tuple[SessionProcesses, dict[str, Path]], site: str, simulation: str
) -> None:
    processes, configurations = session
    for name in (simulation, site):
        processes.start(name, configurations[name])
    wait_until(lambda: state(processes, site) == "disconnected", f"{site} did not start", PATIENCE_S)
    assert end(processes.running[simulation]) == 0
    path = processes.out / f"{site}.json"
    wait_until(lambda: json.loads(path.read_text("utf-8"))["missing"] != "", "the loss was not noticed", PATIENCE_S)
    assert end(processes.running[site]) == 0
    assert_closed(processes.out / f"{site}.mcap")


@pytest.mark.parametrize("site", ["remote", "operator"])
@pytest.mark.parametrize("there", ["nobody", "silent"])
def test_a_site_that_waits_for_its_devices_ends_in_time(
    session: tuple[SessionProcesses, dict[str, Path]], site: str, there: str
) -> None:
    processes, configurations = session
    with contextlib.ExitStack() as ports:
        lines = [
            ports.enter_context(socket.create_server(("127.0.0.1", port)))
            for port in device_ports(configurations[site])
            if there == "silent"
        ]
        processes.start(site, configurations[site])
        process = processes.running[site]
        wait_until(lambda: catches(process.pid, signal.SIGTERM), f"{site} did not start", PATIENCE_S)
        for line in lines:
            line.settimeout(40.0)
            ports.enter_context(line.accept()[0])  # it asks, and nobody will answer
        assert end(process) == 0, processes.last_words(site)


def test_the_supervisor_is_notified_over_the_whole_life_of_a_site(
    session: tuple[SessionProcesses, dict[str, Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    processes, configurations = session
    processes.start("sim-operator", configurations["sim-operator"])
    config = load_config(configurations["operator"], OperatorConfig).model_copy(update={"log": "json"})
    configurations["operator"].write_text(to_toml(config), "utf-8")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        heard.bind(address := str(processes.out / "notify"))
        heard.settimeout(40.0)
        monkeypatch.setenv("NOTIFY_SOCKET", address)
        processes.start("operator", configurations["operator"])
        assert heard.recv(1000) == b"READY=1"
        for _ in range(2):
            assert heard.recv(1000) == b"WATCHDOG=1\nSTATUS=disconnected: no remote site"
        assert end(processes.running["operator"]) == 0
        last = b""
        while last != b"STOPPING=1":
            last = heard.recv(1000)
    lines = (processes.out / "operator.log").read_text("utf-8").splitlines()
    assert {json.loads(line)["process"] for line in lines} == {"operator"}
    assert not processes.last_words("operator").startswith("{")


def device_ports(configuration: Path) -> list[int]:
    """Ports of this machine at which a site looks for its serial devices."""
    words = configuration.read_text("utf-8").replace('"', " ").split()
    return [int(word.rsplit(":", 1)[1]) for word in words if word.startswith("socket://")]


def catches(pid: int, number: signal.Signals) -> bool:
    """Whether a process has a handler of its own for a signal."""
    status = Path(f"/proc/{pid}/status").read_text("ascii")
    mask = next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(int(mask, 16) >> (number - 1) & 1)
