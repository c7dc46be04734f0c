"""Cables are pulled while a session strokes: the site says which, its outputs are safe, and the work goes on after."""

import socket
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from common.limits import CONTACT_FORCE_N, FORCE_SAFE_S, THERMAL_SAFE_S
from studies.fault_session import read_figures
from studies.stroking_scene import write_stroking_scene
from teletaction.demo_files import HOST, PROCESSES, DemoOptions, prepare
from teletaction.processes import SessionProcesses
from tests.session.truth import LATE_S, written
from tests.undisturbed import passes_its_tests, undisturbed

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

INDEX = 1


@dataclass(frozen=True, slots=True)
class Cable:
    """A device to unplug, who simulates it, which site misses it under which name."""

    simulation: str
    device: str
    site: str
    missed_as: str


CABLES = {
    "tacttip": Cable("sim-operator", "index tacttip", "operator", "index tacttip"),
    "exoskeleton": Cable("sim-operator", "can", "operator", "exoskeleton"),
    "texture": Cable("sim-remote", "index texture", "remote", "index texture_sensor"),
    "thermal": Cable("sim-remote", "index thermal", "remote", "index thermal_sensor"),
    "telemanipulator": Cable("sim-remote", "can", "remote", "telemanipulator"),
}


@dataclass(frozen=True, slots=True)
class Pulled:
    """A cable that was out from one time to another, s, and the output folder of its session."""

    name: str
    out_s: float
    back_s: float
    folder: Path
    remote: dict[str, Any]
    operator: dict[str, Any]


class Running:
    """A session in full work whose simulations can be told to fail."""

    def __init__(self, folder: Path) -> None:
        scene = write_stroking_scene(folder, 0.1, 0.95)
        configurations = prepare(DemoOptions(seconds=100.0, fingers=1, scene=str(scene)), folder)
        self.folder = folder
        self.ports = {
            name: tomllib.loads(configurations[name].read_text("utf-8"))["fault_port"]
            for name in ("sim-remote", "sim-operator")
        }
        self.processes = SessionProcesses(folder)
        for process in PROCESSES:
            self.processes.start(process, configurations[process])

    def status(self, name: str) -> dict[str, Any]:
        return read_figures(self.folder, name)

    def until(self, done: Callable[[], object], what: str, seconds: float = 40.0) -> None:
        end_s = time.monotonic() + seconds
        while not done():
            ended = {name: self.processes.last_words(name) for name in self.processes.ended()}
            assert not ended, ended
            assert time.monotonic() < end_s, what
            time.sleep(0.02)

    def until_it_works_for(self, script_s: float) -> None:
        """Until the hand has gone on with its script for that long."""
        before_s = float(self.status("sim-operator").get("script_s") or 0.0)
        self.until(
            lambda: float(self.status("sim-operator").get("script_s") or 0.0) >= before_s + script_s,
            "the session did not get to work",
        )

    def say(self, simulation: str, command: str) -> float:
        """Give a command; returns the time at which it was carried out, s."""
        with socket.create_connection((HOST, self.ports[simulation])) as port:
            port.sendall(command.encode() + b"\n")
            answer = port.makefile("r", encoding="utf-8").readline().split()
        assert answer[0] == "ok", answer
        return int(answer[1]) * 1e-9


@pytest.fixture(scope="module")
def pulled(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> dict[str, Pulled]:
    """One session in which each cable was pulled, missed, and put back."""
    return undisturbed(lambda: tell(tmp_path_factory.mktemp("unplugged")), passes_its_tests(request))


def tell(folder: Path) -> dict[str, Pulled]:
    session = Running(folder)
    found = {}
    try:
        session.until_it_works_for(3.0)
        for name, cable in CABLES.items():
            out_s = session.say(cable.simulation, f"unplug {cable.device}")
            session.until(
                lambda cable=cable: str(session.status(cable.site).get("missing")).startswith(cable.missed_as),  # type: ignore[misc]
                f"{cable.site} did not miss {cable.missed_as}",
            )
            session.until_it_works_for(1.0)
            back_s = session.say(cable.simulation, f"plug {cable.device}")
            session.until(
                lambda cable=cable: session.status(cable.site).get("missing") == "",  # type: ignore[misc]
                f"{cable.site} did not find {cable.missed_as} again",
            )
            session.until_it_works_for(8.0)  # the whole script once: touching, stroking
            found[name] = Pulled(name, out_s, back_s, folder, session.status("remote"), session.status("operator"))
    finally:
        session.processes.end()
    return found


@pytest.mark.parametrize("name", CABLES)
def test_the_session_goes_on_when_the_cable_is_back(name: str, pulled: dict[str, Pulled]) -> None:
    case = pulled[name]
    assert (case.remote["state"], case.remote["fault"]) == ("engaged", "")
    assert (case.operator["state"], case.operator["fault"]) == ("engaged", "")
    site = case.operator if CABLES[name].site == "operator" else case.remote
    assert site["devices"][CABLES[name].missed_as]["times_lost"] == 1
    felt = written(
        case.folder / "sim-operator.mcap", "truth_fingertips", case.back_s, case.back_s + 8.0, may_be_cut=True
    )
    assert max(entry["force_n"][INDEX] for _, entry in felt) > 0.2
    assert max(entry["motor_mv"][INDEX] for _, entry in felt) > 0
    assert max(abs(entry["peltier"][INDEX]) for _, entry in felt) > 0.0


@pytest.mark.parametrize(
    ("name", "output", "within_s"),
    [
        ("tacttip", "motor_mv", FORCE_SAFE_S),
        ("tacttip", "peltier", THERMAL_SAFE_S),
        ("exoskeleton", "force_n", FORCE_SAFE_S),
        ("telemanipulator", "force_n", FORCE_SAFE_S + FORCE_SAFE_S),  # the remote site misses it first
        ("telemanipulator", "motor_mv", FORCE_SAFE_S + FORCE_SAFE_S),
    ],
)
def test_what_hung_on_the_cable_is_off_while_it_is_out(
    name: str, output: str, within_s: float, pulled: dict[str, Pulled]
) -> None:
    case = pulled[name]
    path = case.folder / "sim-operator.mcap"
    entries = written(path, "truth_fingertips", case.out_s + within_s + LATE_S, case.back_s, may_be_cut=True)
    assert len(entries) > 50
    assert not any(entry[output][INDEX] for _, entry in entries)


def test_a_heater_without_its_cable_is_off(pulled: dict[str, Pulled]) -> None:
    case = pulled["thermal"]
    path = case.folder / "sim-remote.mcap"
    entries = written(path, "truth_contact", case.out_s + THERMAL_SAFE_S + LATE_S, case.back_s, may_be_cut=True)
    assert len(entries) > 50
    assert not any(entry["heater"][INDEX] for _, entry in entries)


def test_nobody_is_pressed_too_hard_whatever_is_unplugged(pulled: dict[str, Pulled]) -> None:
    first, last = pulled["tacttip"], pulled["telemanipulator"]
    entries = written(
        first.folder / "sim-remote.mcap", "truth_contact", first.out_s, last.back_s + 8.0, may_be_cut=True
    )
    assert max(entry["force_n"][INDEX] for _, entry in entries) <= CONTACT_FORCE_N
