"""Every command of docs/howto/real-hardware.md, in its order, on simulated devices under the page's names."""

import json
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from common.config.file import load_config
from common.config.site_models import OperatorConfig, RemoteConfig
from teletaction.conformance.checklist import HALF_A_REPORT_S
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.places import ROOT

# Devices are judged by their times: half a report is what a trial grants.
pytestmark = [pytest.mark.pages, pytest.mark.real_time(stall_s=HALF_A_REPORT_S), pytest.mark.timeout(600)]

PAGE = (ROOT / "docs" / "howto" / "real-hardware.md").read_text("utf-8")
SHOWN = ("S1 ", "ok ", "FAIL ", " ")
"""Indented lines that begin so are what a command prints."""
COMMANDS = [line[4:] for line in re.findall(r"(?m)^    .*$", PAGE) if not line[4:].startswith(SHOWN)]
TRIALS = [line for line in COMMANDS if line.startswith("teletaction conformance ")]
DOCTORS = [line for line in COMMANDS if line.startswith("teletaction doctor --config ")]
SESSION = [line for line in COMMANDS if re.match(r"teletaction (remote|operator|session) ", line)]
HERE = "teletaction doctor"
DEVICES = (
    ("index texture sensor", "index thermal sensor", "patient switch", "telemanipulator"),
    ("index tacttip", "exoskeleton"),
)
"""Of the remote site and of the operator's, in the doctor's order."""


class Bench:
    """Simulated devices of one finger, and the configurations of both sites under the page's names.

    Attributes:
        folder: where the configurations and the sites' status files are.
        names: the page's name of each device, and the simulated one's address.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes = SessionProcesses(folder)
        made = prepare(DemoOptions(fingers=1), folder)
        for site in ("remote", "operator"):
            shutil.copy(made[site], folder / f"{site}.toml")
        for name in ("sim-remote", "sim-operator"):
            self.processes.start(name, made[name])
        remote, operator = load_config(made["remote"], RemoteConfig), load_config(made["operator"], OperatorConfig)
        assert remote.patient_switch is not None
        self.names = {
            "/dev/patient-switch": remote.patient_switch.port,
            "/dev/texture-index": remote.texture["index"],
            "/dev/thermal-index": remote.thermal_sensors["index"],
            "/dev/tacttip-index": operator.tacttip["index"],
            "socketcan:can0 --device telemanipulator": f"{remote.telemanipulator} --device telemanipulator",
            "socketcan:can0 --device exoskeleton": f"{operator.exoskeleton} --device exoskeleton",
        }
        self.until(lambda: all((folder / f"{name}.json").exists() for name in self.processes.running), "devices")

    def until(self, done: Callable[[], bool], what: str) -> None:
        deadline_s = time.monotonic() + 30.0
        while not done():
            assert time.monotonic() < deadline_s, what
            time.sleep(0.02)

    def give(self, line: str) -> subprocess.CompletedProcess[str]:
        """Give one command of the page; what it asks is answered with yes."""
        for name, address in self.names.items():
            line = line.replace(name, address)
        for site in ("remote", "operator"):
            line = line.replace(f"{site}.toml", shlex.quote(str(self.folder / f"{site}.toml")))
        program, *arguments = shlex.split(line)
        assert program == "teletaction"
        return subprocess.run(
            [sys.executable, "-m", "teletaction", *arguments],
            input="y\n",
            capture_output=True,
            text=True,
            timeout=200,
            check=False,
        )

    def state(self, site: str) -> str:
        """What a site's status file says of its session."""
        try:
            return str(json.loads((self.folder / f"{site}.json").read_text("utf-8")).get("state"))
        except (FileNotFoundError, json.JSONDecodeError):
            return "not there"


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    made = Bench(tmp_path_factory.mktemp("bench"))
    yield made
    made.processes.end()


def test_every_command_of_the_page_is_known_here() -> None:
    assert sorted(COMMANDS) == sorted([HERE, *TRIALS, *DOCTORS, *SESSION])
    assert all((TRIALS, DOCTORS, SESSION))


def test_devices_of_this_host_are_listed(bench: Bench) -> None:
    assert HERE in COMMANDS
    result = bench.give(HERE)
    assert result.returncode == 0 or "no device answers at the serial ports" in result.stderr


def test_each_device_keeps_its_duties(bench: Bench) -> None:
    # All devices at once, and never two trials at one of them.
    by_device: dict[str, list[str]] = {}
    for line in TRIALS:
        by_device.setdefault(next(name for name in bench.names if name in line), []).append(line)
    assert by_device.keys() == bench.names.keys()

    def give(lines: list[str]) -> list[subprocess.CompletedProcess[str]]:
        return [bench.give(line) for line in lines]

    with ThreadPoolExecutor(len(bench.names)) as pool:
        for result in (each for group in pool.map(give, by_device.values()) for each in group):
            assert result.returncode == 0, result.stdout + result.stderr
            assert "S1   pass" in result.stdout or "N1   pass" in result.stdout


def test_the_doctor_finds_and_exercises_the_devices(bench: Bench) -> None:
    with ThreadPoolExecutor(len(DOCTORS)) as pool:
        both = list(pool.map(bench.give, DOCTORS))
    for line, result in zip(DOCTORS, both, strict=True):
        assert result.returncode == 0, result.stdout + result.stderr
        found = [words.split(":")[0] for words in result.stdout.splitlines()]
        devices = DEVICES["operator.toml" in line]
        assert [f"ok   {device}" for device in devices] == [each for each in found if each[5:] in devices]
        assert ("index tacttip, exercised: D4 pass" in result.stdout) == ("--exercise" in line)


def test_the_session_runs_as_the_page_says(bench: Bench) -> None:
    for line in SESSION:
        words = line.split()
        if words[1] in ("remote", "operator"):
            assert words[2:] == ["--config", f"{words[1]}.toml"]
            bench.processes.start(words[1], bench.folder / words[3])
            continue
        bench.until(lambda: bench.state("operator") not in ("not there", "disconnected"), "no session")
        if line.startswith("teletaction session clear"):
            assert bench.give("teletaction session estop --config remote.toml").returncode == 0
        result = bench.give(line)
        assert result.returncode == 0, (line, result.stdout + result.stderr)
