"""Runs a whole session on two hosts whose clocks differ by an hour and drift apart.

The remote site has a network namespace, a time namespace and a drifting clock. Simulated devices keep the machine's
clock, and so does the operator site. The true time of all that the remote site records is therefore known.
"""

import os
import signal
import sys
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from pydantic import BaseModel

from common.config.file import load_config, to_toml
from common.config.page_models import ConsoleConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.config.stream_models import CameraConfig
from robustness.fault_session import read_figures
from teletaction.session.demo_files import DemoOptions, prepare
from tests.network.link_bench import BASE_PORT
from tests.network.two_hosts import REMOTE, Host, Program, Way, two_hosts
from tests.waiting import wait_until

LEAD_S = 3600
"""Lead of the remote host's clock when its site starts, s."""
DRIFT = 50e-6
"""Relative rate by which the remote host's clock is fast, s/s."""
SECONDS = 8.0
"""Duration of the exploration, s."""
FINGERS = 2
SESSION = DemoOptions(seconds=SECONDS, fingers=FINGERS)
JITTER_MS = 1.0
"""Standard deviation of a packet's delay, ms."""
_PATIENCE_S = 60.0


class Delays(NamedTuple):
    """Mean delay of the packets that arrive at each host, ms."""

    to_remote_ms: float
    to_operator_ms: float


@dataclass(frozen=True, slots=True)
class RemoteClock:
    """Clock of the remote host.

    Attributes:
        start_ns: reading at which its drift began, ns.
    """

    start_ns: int

    def true_ns(self, remote_ns: int) -> int:
        """Convert a reading to the machine's monotonic clock, ns."""
        ran_ns = remote_ns - self.start_ns
        return remote_ns - round(ran_ns * DRIFT / (1.0 + DRIFT)) - LEAD_S * 10**9


class TwoHostSession:
    """The four processes of a session, which end with `ends`."""

    def __init__(
        self,
        ends: ExitStack,
        out: Path,
        delays: Delays,
        step_s: float = 0.0,
        way: Way | None = None,
        options: DemoOptions = SESSION,
    ):
        """Start the session.

        Args:
            ends: ends the processes and the hosts.
            out: folder for the files of the session.
            delays: delays of the network between the hosts.
            step_s: step of both sites' wall clocks in `step_wall_clocks`, s.
            way: joins the hosts in another way than by their addresses.
            options: of the session. With a console, too, it engages by itself. A voice is not known here.
        """
        self.out = out
        self._step_s = step_s
        self.hosts = ends.enter_context(two_hosts())
        address = way(self.hosts, out) if way else REMOTE
        self._files = prepare(options, out)
        _on_two_hosts(self._files, address)
        self.hosts.remote.impair(delays.to_remote_ms, JITTER_MS, 0.0)
        self.hosts.operator.impair(delays.to_operator_ms, JITTER_MS, 0.0)
        self._programs: dict[str, Program] = {}
        self._pids: dict[str, int] = {}
        self._start(self.hosts.remote, "sim-remote")
        self._start(self.hosts.operator, "sim-operator")
        self.remote_clock = self.boot_remote(LEAD_S)
        self._start(self.hosts.operator, "operator")
        if options.camera:
            self._start(self.hosts.remote, "camera", _boot(LEAD_S), DRIFT)
        if options.console:
            self._start(self.hosts.operator, "console")

    def boot_remote(self, lead_s: int) -> RemoteClock:
        """Start the remote site on a host whose clock is ahead by `lead_s` (s); an earlier one ends first."""
        if "remote" in self._programs:
            self._programs["remote"].end()
        return RemoteClock(self._start(self.hosts.remote, "remote", _boot(lead_s), DRIFT))

    def wait_for_script(self, script_s: float) -> None:
        """Wait until the hand has explored for a time, s."""
        wait_until(lambda: (self._hand().get("script_s") or 0.0) >= script_s, "no exploration", _PATIENCE_S)

    def wait_for_connection(self) -> None:
        """Wait until the remote site is connected to the operator site."""

        def connected() -> bool:
            return read_figures(self.out, "remote").get("state") in ("connected", "engaging", "engaged")

        wait_until(connected, "the remote site is not connected", _PATIENCE_S)

    def finish(self) -> None:
        """Wait for the end of the exploration, and end all processes."""
        wait_until(lambda: self._hand().get("finished"), "the exploration does not end", _PATIENCE_S)
        self.end()

    def end(self) -> None:
        """End all processes; their recordings and status files are then complete."""
        for program in reversed(self._programs.values()):
            program.end()

    def step_wall_clocks(self) -> list[int]:
        """Step the wall clock of each site; return by how much each lead over the monotonic clock changed, ns."""
        changed_ns = []
        for site in ("remote", "operator"):
            os.kill(self._pids[site], signal.SIGUSR1)
            before_ns, after_ns = map(int, self._programs[site].hear().split())
            changed_ns.append(after_ns - before_ns)
        return changed_ns

    def _hand(self) -> dict[str, object]:
        return read_figures(self.out, "sim-operator")

    def _start(self, host: Host, name: str, boot: tuple[str, ...] = (), drift: float = 0.0) -> int:
        """Start a process; return its monotonic clock at the start, ns."""
        run = (sys.executable, "-m", "tests.network.host_process", str(drift), str(self._step_s))
        program = host.start(*boot, *run, name, "--config", str(self._files[name]))
        self._programs[name] = program
        self._pids[name], start_ns = map(int, program.hear().split())
        return start_ns


def _boot(lead_s: int) -> tuple[str, ...]:
    """Return the command that starts a program with clocks that lead by `lead_s`, s."""
    return "unshare", "--time", "--kill-child", "--monotonic", str(lead_s), "--boottime", str(lead_s)


def _on_two_hosts(files: dict[str, Path], address: str) -> None:
    """Move the link of a session's configurations from this machine to the address of the remote site."""
    here, there = {"bind": address, "base_port": BASE_PORT}, {"host": address, "base_port": BASE_PORT}
    _update(files["remote"], RemoteConfig, link=here)
    _update(files["operator"], OperatorConfig, link=there)
    if "camera" in files:
        _update(files["camera"], CameraConfig, link=here)
        _update(files["console"], ConsoleConfig, camera=there)
    if "console" in files:
        config = load_config(files["operator"], OperatorConfig)
        files["operator"].write_text(to_toml(config.model_copy(update={"engage": True, "console_required_s": 0.0})))


def _update(file: Path, kind: type[BaseModel], **groups: dict[str, object]) -> None:
    """Replace fields of groups of a configuration."""
    config = load_config(file, kind)
    changed = {name: getattr(config, name).model_copy(update=fields) for name, fields in groups.items()}
    file.write_text(to_toml(config.model_copy(update=changed)), "utf-8")
