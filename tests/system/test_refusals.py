"""Refusals that need devices and a peer: swapped devices and keys that are not allowed."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from common.link.keys import TrustedKeys
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


def test_an_untrusted_key_gets_the_reason(simulated: dict[str, Path], tmp_path: Path) -> None:
    TrustedKeys(tmp_path / "keys" / "remote").revoke("operator")
    processes = SessionProcesses(tmp_path)
    try:
        processes.start("remote", simulated["remote"])
        refused = run("operator", "--config", str(simulated["operator"]))
    finally:
        processes.end()
    assert refused.returncode == 2
    assert "does not trust this site's key" in last_line(refused.stderr)
    assert "Traceback" not in refused.stderr
