"""A session of real processes on this machine, into which faults are injected."""

import json
import os
import resource
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common.config.file import load_config, load_site, to_toml
from common.config.simulation_models import SimNetworkConfig, SimOperatorConfig, SimRemoteConfig
from common.files.unique_path import set_aside
from common.link.keys import load_keys
from common.link.local_control import ask_desk
from robustness.faulted_session import FaultedSession, NotWorking
from robustness.stroking_scene import write_stroking_scene
from teletaction.session.demo_files import NETWORK, DemoOptions, prepare
from teletaction.session.demo_ports import HOST
from teletaction.session.processes import SessionProcesses, family

_STROKES = 20
"""Number of strokes to and fro. The middle finger strokes; the index finger stays beside the object, so that its
sensor's heater works."""
_MODELS: dict[str, Any] = {
    "sim-remote": SimRemoteConfig,
    "sim-operator": SimOperatorConfig,
    NETWORK: SimNetworkConfig,
}


@dataclass(slots=True)
class FaultSession(FaultedSession):
    """Five processes: both sites, both simulations, and the network between the sites."""

    out: Path
    processes: SessionProcesses
    configurations: dict[str, Path]
    restarts: dict[str, int] = field(default_factory=dict)
    _ports: dict[str, int] = field(default_factory=dict)

    @classmethod
    @contextmanager
    def open(cls, out: Path, *, patient_switch: bool = False, **site: object) -> "Iterator[FaultSession]":
        """Start a session, and end it on exit.

        Args:
            out: folder of its files.
            patient_switch: whether the patient has a stop switch.
            site: fields of both sites' configurations.
        """
        network = out / "direct.toml"
        network.write_text("[[phase]]\nfrom_s = 0\ndelay_ms = 0\n", "utf-8")
        configurations = prepare_session(out, network, patient_switch=patient_switch)
        for name in ("remote", "operator"):
            changed = load_site(configurations[name]).model_copy(update=site)
            configurations[name].write_text(to_toml(changed), "utf-8")
        session = cls(out, SessionProcesses(out), configurations)
        try:
            for name, path in configurations.items():
                session.processes.start(name, path)
                if name in _MODELS:
                    session._ports[name] = load_config(path, _MODELS[name]).fault_port
            yield session
        finally:
            for name in session.processes.running:
                session.signal(name, signal.SIGCONT)
            session.processes.end()

    def now_s(self) -> float:
        """The processes' clock, s."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        time.sleep(seconds)

    def command(self, process: str, line: str) -> float:
        """Make a simulation fail, or mend it; returns when that took effect, s.

        Raises:
            NotWorking: the simulation refuses the command, or has ended.
        """
        try:
            with socket.create_connection((HOST, self._ports[process]), timeout=5.0) as port:
                port.sendall(line.encode() + b"\n")
                answer = port.makefile().readline().split()
        except OSError as error:
            raise NotWorking(f"{process}: {line}: {error}") from None
        if answer[:1] != ["ok"]:
            raise NotWorking(f"{process}: {line}: {' '.join(answer)}")
        return int(answer[1]) * 1e-9

    def mend(self) -> None:
        """End every fault of both simulations and of the network."""
        for name in ("sim-remote", "sim-operator"):
            self.command(name, "mend")
        self.command(NETWORK, "clear")

    def signal(self, process: str, number: int) -> float:
        """Send a signal to a process; returns a time just before, s."""
        at_s = time.monotonic()
        if self.processes.running[process].poll() is None:
            self.processes.running[process].send_signal(number)
        return at_s

    def restart(self, process: str) -> float:
        """Start a killed process again, as a supervisor would, and set its earlier log aside; returns when, s."""
        self.processes.running[process].wait()
        self.restarts[process] = self.restarts.get(process, 0) + 1
        set_aside(self.out / f"{process}.log")
        self.processes.start(process, self.configurations[process])
        return time.monotonic()

    def stop(self, process: str, seconds: float) -> tuple[float, float]:
        """Stop a process for some time; returns when that began and ended, s."""
        begin_s = self.signal(process, signal.SIGSTOP)
        time.sleep(seconds)
        return begin_s, self.signal(process, signal.SIGCONT)

    def fill_disk(self, *, full: bool) -> float:
        """Keep both sites from writing to any file, or let them write again; returns when, s."""
        for site in ("remote", "operator"):
            let_write(self.processes.running[site].pid, allowed=not full)
        return time.monotonic()

    def burn(self, seconds: float) -> float:
        """Load every processor twice for `seconds`; returns when that ended, s."""
        code = f"import time\nend = time.monotonic() + {seconds}\nwhile time.monotonic() < end: pass"
        hogs = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(2 * (os.cpu_count() or 1))]
        for hog in hogs:
            hog.wait()
        return time.monotonic()

    def ask(self, site: str, verb: str) -> dict[str, Any]:
        """Send a request to the desk of a site, as a person there would.

        Raises:
            LinkProblem, Refused: the site does not answer, or refuses.
        """
        config = load_site(self.configurations[site])
        return ask_desk(config.desk_port, load_keys(config.link.keys), verb)

    def figures(self, process: str) -> dict[str, Any]:
        """Newest status in the status file of a process; empty before the first."""
        return read_figures(self.out, process)


def prepare_session(out: Path, network: Path | None = None, *, patient_switch: bool = False) -> dict[str, Path]:
    """Write configuration files for a session of two fingers that stroke for an hour; returns them by process.

    Args:
        out: folder for them and for the session's recordings.
        network: file of the network between the sites; without it, the sites connect directly.
        patient_switch: whether the patient has a stop switch.
    """
    scene = write_stroking_scene(out, 0.1, *(0.95, 0.1) * _STROKES, narrow=True)
    options = DemoOptions(
        seconds=3600.0,
        fingers=2,
        scene=str(scene),
        network=None if network is None else str(network),
        patient_switch=patient_switch,
    )
    return prepare(options, out)


def let_write(pid: int, *, allowed: bool) -> None:
    """Let a process and its children write to files, or to none, as on a full disk."""
    for member in family(pid):
        _, hard = resource.prlimit(member, resource.RLIMIT_FSIZE)
        resource.prlimit(member, resource.RLIMIT_FSIZE, (hard if allowed else 1, hard))


def read_figures(out: Path, process: str) -> dict[str, Any]:
    """Newest status in the status file of a process of the session in `out`; empty before the first."""
    try:
        status: dict[str, Any] = json.loads((out / f"{process}.json").read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return status
