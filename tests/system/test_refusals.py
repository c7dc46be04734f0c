"""Refusals that need devices and a peer: swapped devices and keys that are not allowed."""

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from common.health import find_problem
from common.link.keys import TrustedKeys, load_keys
from robustness.fault_session import read_figures
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.waiting import wait_until

pytestmark = [pytest.mark.session, pytest.mark.timeout(60)]


@pytest.fixture
def simulated(tmp_path: Path) -> Iterator[dict[str, Path]]:
    """Configurations of a two-finger session whose simulated devices are running."""
    configurations = prepare(DemoOptions(fingers=2), tmp_path)
    processes = SessionProcesses(tmp_path)
    try:
        for name in ("sim-remote", "sim-operator"):
            processes.start(name, configurations[name])
        status = [tmp_path / f"{name}.json" for name in processes.running]
        wait_until(lambda: all(file.exists() for file in status), "the simulated devices did not start", 20.0)
        yield configurations
    finally:
        processes.end()


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "teletaction", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=40, check=False)


def last_line(text: str) -> str:
    return text.strip().splitlines()[-1]


def test_swapped_devices_are_refused_by_name(simulated: dict[str, Path]) -> None:
    config = simulated["operator"]
    text = config.read_text("utf-8")
    index, middle = (line.split(" = ")[1] for line in text.splitlines() if line.startswith(("index = ", "middle = ")))
    swapped = text.replace(f"index = {index}", f"index = {middle}")
    swapped = swapped.replace(f"middle = {middle}", f"middle = {index}", 1)
    config.write_text(swapped, "utf-8")
    refused = run("operator", "--config", str(config))
    assert refused.returncode == 2
    line = last_line(refused.stderr)
    assert "is the middle's tacttip" in line or "is the index's tacttip" in line
    assert "Traceback" not in refused.stderr


def test_a_site_with_an_untrusted_key_reports_the_reason_and_works_once_it_is_trusted(
    simulated: dict[str, Path], tmp_path: Path
) -> None:
    trusted = TrustedKeys(tmp_path / "keys" / "remote")
    trusted.revoke("operator")
    processes = SessionProcesses(tmp_path)

    def reported(name: str) -> str:
        return str(read_figures(tmp_path, "operator").get(name))

    try:
        for name in ("remote", "operator"):
            processes.start(name, simulated[name])
        wait_until(lambda: "does not trust this site's key" in reported("refusal"), "no reason", 20.0)
        assert "does not trust this site's key" in find_problem(tmp_path / "operator.json", time.monotonic_ns())
        trusted.trust("operator", load_keys(tmp_path / "keys" / "operator").public)
        wait_until(lambda: reported("state") == "engaged", lambda: reported("refusal"), 20.0)
        assert processes.ended() == {}
    finally:
        processes.end()
    log = (tmp_path / "operator.log").read_text("utf-8")
    assert log.count("does not trust this site's key") == 1
    assert "Traceback" not in log
