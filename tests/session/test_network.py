"""Sessions over a bad network: outputs are safe while it is too late or broken, and come back when it does."""

import json
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from common import limits
from common.config import SimNetworkConfig, load_config
from studies.fault_session import read_figures
from studies.stroking_scene import write_stroking_scene
from teletaction.demo_files import DemoOptions, prepare
from teletaction.processes import SessionProcesses
from tests.session.truth import LATE_S, written
from tests.undisturbed import undisturbed

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

INDEX = 1
ON_THE_WAY_S = 0.012
"""What `city` was carrying when it broke still arrives."""


@contextmanager
def session(out: Path, network: str) -> Iterator[SessionProcesses]:
    """A finger that strokes over a network, ended at the end; the network's timetable is not started."""
    scene = write_stroking_scene(out, *(0.05, 0.95) * 5, 0.05, lift=False)  # almost a minute
    processes = SessionProcesses(out)
    options = DemoOptions(seconds=60.0, fingers=1, scene=str(scene), network=network)
    try:
        for name, config in prepare(options, out).items():
            processes.start(name, config)
        yield processes
    finally:
        processes.end()


def script_s(out: Path) -> float:
    """How long the hand has worked, s; 0 before."""
    return float(read_figures(out, "sim-operator").get("script_s") or 0.0)


def refused(out: Path, site: str) -> int:
    told = read_figures(out, site).get("refused", {})
    return sum(sum(count.values()) for stream, count in told.items() if stream != "damaged")


def wait_for(what: str, there: Callable[[], object], processes: SessionProcesses) -> None:
    deadline_s = time.monotonic() + 40.0
    while not there():
        assert processes.ended() == {}
        assert time.monotonic() < deadline_s, what
        time.sleep(0.02)


def tell(out: Path, command: str) -> float:
    """Tell the network what to do; when it did so, s."""
    port = load_config(out / "config" / "network.toml", SimNetworkConfig).fault_port
    with socket.create_connection(("127.0.0.1", port or 0), timeout=5.0) as network:
        network.sendall(command.encode() + b"\n")
        answer = network.recv(200).decode().split()
    assert answer[0] == "ok", answer
    return int(answer[1]) * 1e-9


def test_a_demo_over_a_network_says_what_the_network_did(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-m", "teletaction", "demo", "--headless", "--seconds", "8", "--fingers", "1"]
    run = subprocess.run(
        [*command, "--network", "bad_evening", "--out", str(out)],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["network"] == "bad_evening"
    assert summary["faults"] == []
    assert [(fault["at_s"], fault["kind"]) for fault in summary["proxy"]["faults"][:2]] == [
        (2.0, "stall"),
        (5.0, "cut"),
    ]
    assert summary["proxy"]["streams"]["motion"]["to_remote"]["bytes"] > 30_000
    assert summary["latency_ms"]["link_one_way"]["p50"] > 12.0
    assert 0.0 < summary["force_n"]["max"] <= limits.FINGER_FORCE_N
    assert summary["contact_force_n"]["max"] <= limits.CONTACT_FORCE_N
    assert "network" in summary["loop"]
    assert (out / "network.log").is_file()


def test_over_a_satellite_nothing_ever_acts(tmp_path: Path) -> None:
    with session(tmp_path, "satellite") as processes:
        wait_for("packets to refuse", lambda: refused(tmp_path, "operator") > 200, processes)
        assert refused(tmp_path, "remote") > 0 or read_figures(tmp_path, "remote")["received"]["motion"] == 0
    assert read_figures(tmp_path, "operator")["received"]["touch"] == 0
    assert script_s(tmp_path) == 0.0
    entries = written(tmp_path / "sim-operator.mcap", "truth_fingertips")
    assert len(entries) > 100
    for _, entry in entries:
        assert entry["force_n"][INDEX] == 0.0
        assert entry["motor_mv"][INDEX] == 0
        assert entry["peltier"][INDEX] == 0.0


def test_a_partition_makes_outputs_safe_and_the_session_comes_back(tmp_path: Path) -> None:
    def works() -> bool:
        return all(read_figures(tmp_path, site).get("state") == "engaged" for site in ("remote", "operator"))

    with session(tmp_path, "city") as processes:
        wait_for("work", lambda: script_s(tmp_path) > 3.0, processes)
        begin_s = tell(tmp_path, "partition 3")
        wait_for("the end of the session", lambda: not works(), processes)
        wait_for("a new session", works, processes)
        again_s, then_s = time.monotonic(), script_s(tmp_path)
        wait_for("more work", lambda: script_s(tmp_path) > then_s + 3.0, processes)
    entries = written(tmp_path / "sim-operator.mcap", "truth_fingertips")
    before = [entry for t, entry in entries if begin_s - 0.5 < t < begin_s]
    after = [entry for t, entry in entries if t > again_s]
    for working in (before, after):
        assert max(entry["force_n"][INDEX] for entry in working) > 0.2
        assert max(entry["motor_mv"][INDEX] for entry in working) > 0
    broken = [(t - begin_s, entry) for t, entry in entries if begin_s < t < begin_s + 3.0]
    assert max(t for t, _ in broken) > 2.9
    for t, entry in broken:
        safe_for_s = t - ON_THE_WAY_S - LATE_S
        assert safe_for_s < limits.FORCE_SAFE_S or entry["force_n"][INDEX] == 0.0, t
        assert safe_for_s < limits.MOTOR_SAFE_S or entry["motor_mv"][INDEX] == 0, t
        assert safe_for_s < limits.THERMAL_SAFE_S or entry["peltier"][INDEX] == 0.0, t


def test_a_cut_connection_is_made_anew_within_the_same_session(tmp_path_factory: pytest.TempPathFactory) -> None:
    def cut(out: Path) -> dict[str, str]:
        """What both sites wrote into their logs about a session that went on after a cut."""

        def carried() -> int:
            streams = read_figures(out, "network").get("streams", {})
            return min((int(streams[name]["connections_open"]) for name in ("motion", "touch")), default=0)

        with session(out, "lan") as processes:
            wait_for("work", lambda: script_s(out) > 1.0, processes)
            made = read_figures(out, "network")["streams"]["motion"]["connections_made"]
            tell(out, "cut")
            wait_for(
                "a new connection",
                lambda: read_figures(out, "network")["streams"]["motion"]["connections_made"] > made and carried(),
                processes,
            )
            accepted = read_figures(out, "operator")["received"]["touch"]
            wait_for("touch", lambda: read_figures(out, "operator")["received"]["touch"] > accepted + 100, processes)
        return {site: (out / f"{site}.log").read_text("utf-8") for site in ("operator", "remote")}

    def fine(logs: dict[str, str]) -> bool:
        return not any("silent" in log for log in logs.values())

    logs = undisturbed(lambda: cut(tmp_path_factory.mktemp("cut")), fine)
    assert fine(logs), logs
