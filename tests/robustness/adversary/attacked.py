"""A one-finger session of real processes with attackers beside it, and its judge."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common.config import OperatorConfig, RemoteConfig, load_config
from common.limits import FINGER_FORCE_N, FORCE_SAFE_S
from common.link.keys import Role, TrustedKeys, create_keys, load_keys
from common.link.local_control import stop_from_desk
from robustness.fault_session import FaultSession
from robustness.faults import read_truth
from robustness.stroking_scene import write_stroking_scene
from teletaction.session.demo_files import CONSOLE, DemoOptions, prepare
from teletaction.session.processes import SessionProcesses, die_with_parent
from tests.system.page import Page, opened
from tests.system.truth import LATE_S, written

REACH_M = (-0.002, 0.287)
"""The operator's script strokes from 0.03 to 0.285 m; between sessions the hand goes home to 0."""
_STROKES = 20
SITES = ("remote", "operator")


@dataclass
class Stop:
    """One emergency stop at the operator's desk: when it was asked for, answered, and cleared, s; and the answer."""

    asked_s: float
    answered_s: float
    said: str
    cleared_s: float = float("inf")


@dataclass
class Attacked:
    """The processes, and what was done."""

    out: Path
    session: FaultSession
    page: Page | None = None
    """The console's page, where stops are pressed; without, at the operator's desk."""
    stops: list[Stop] = field(default_factory=list)
    attackers: list["subprocess.Popen[bytes]"] = field(default_factory=list)

    def attack(self, what: str, who: str, *options: str) -> None:
        """Start an attacker: `who` is second, observer, stranger, or operator, whose key is copied."""
        remote = load_config(self.session.configurations["remote"], RemoteConfig)
        operator = load_config(self.session.configurations["operator"], OperatorConfig)
        keys = self.out / "keys"
        ports = ("--desk", str(operator.desk_port), "--feed", str(operator.feed_port))
        ports += ("--operator-key", load_keys(keys / "operator").public)
        target = (str(keys / who), str(remote.link.base_port), load_keys(keys / "remote").public)
        command = [sys.executable, "-m", "tests.robustness.adversary.run_attacker", what, *target, *ports, *options]
        with (self.out / f"attacker-{len(self.attackers)}.log").open("wb") as log:
            self.attackers.append(
                subprocess.Popen(command, stdout=log, stderr=log, preexec_fn=die_with_parent)  # noqa: PLW1509
            )

    def end_attacks(self) -> None:
        """End every attacker."""
        for attacker in self.attackers:
            attacker.kill()
            attacker.wait()
        self.attackers.clear()

    def stop_and_engage(self) -> Stop:
        """Stop at the console, or at the operator's desk; then clear and engage again."""
        config = load_config(self.session.configurations["operator"], OperatorConfig)
        asked_s = time.monotonic()
        if self.page is None:
            said = stop_from_desk(config.desk_port, load_keys(config.link.keys))
        else:
            said = str(self.page.ask("estop")["text"])
        stop = Stop(asked_s, time.monotonic(), said)
        self.stops.append(stop)
        self.wait(0.3)
        stop.cleared_s = time.monotonic()
        self.session.clear_and_engage()
        return stop

    def wait(self, seconds: float) -> None:
        """Let time pass; somebody looks at the page."""
        if self.page is None:
            time.sleep(seconds)
        else:
            self.page.look(seconds)

    def rss_mib(self) -> dict[str, float]:
        """Memory of each site's own process now, MiB."""
        found = {}
        for name in SITES:
            status = Path(f"/proc/{self.session.processes.running[name].pid}/status").read_text("ascii")
            found[name] = int(status.split("VmRSS:")[1].split()[0]) / 1024.0
        return found

    def figures(self) -> dict[str, dict[str, Any]]:
        """The status file of each site."""
        return {name: self.session.figures(name) for name in SITES}

    def judge_devices(self) -> dict[str, float]:
        """What the simulated devices wrote down, once all processes have ended.

        Raises:
            AssertionError: somebody but the operator moved the hand, or a force lasted after a stop.
        """
        truth = read_truth(self.out)
        assert REACH_M[0] <= truth.hand_x_m.min(), truth.hand_x_m.min()
        assert truth.hand_x_m.max() <= REACH_M[1], truth.hand_x_m.max()
        assert truth.force_n.max() <= FINGER_FORCE_N
        for stop in self.stops:
            safe = (truth.finger_s > stop.answered_s + FORCE_SAFE_S + LATE_S) & (truth.finger_s < stop.cleared_s)
            assert not truth.force_n[safe].any(), stop
        return {
            "x_min_m": float(truth.hand_x_m.min()),
            "x_max_m": float(truth.hand_x_m.max()),
            "force_max_n": float(truth.force_n.max()),
        }

    def recorded_stops(self) -> dict[str, int]:
        """Stops in each record: of both sites, and in the console's record of acts."""

        def noted(site: str, text: str) -> int:
            entries = written(self.out / f"{site}.mcap", f"{site}/session")
            return sum(what == "estop" and said.startswith(text) for _, (what, _, said, _) in entries)

        found = {"operator": noted("operator", "here: "), "remote": noted("remote", "")}
        if self.page is not None:
            acts = written(self.out / f"{CONSOLE}.mcap", "console/act")
            found[CONSOLE] = sum(act["verb"] == "estop" and act["ok"] is True for _, act in acts)
        return found


@contextmanager
def attacked_session(out: Path, *, console: bool = False) -> Iterator[Attacked]:
    """Start both sites and their simulated devices, wait until they work, and end them and their attackers.

    With a `console` a page of it is looked at, and the session engages without it all the same.
    """
    out.mkdir(parents=True, exist_ok=True)
    scene = write_stroking_scene(out, 0.1, *(0.95, 0.1) * _STROKES)
    configurations = prepare(DemoOptions(seconds=None, fingers=1, scene=str(scene), console=console), out)
    file = configurations["operator"]
    text = file.read_text("utf-8").replace("engage = false", "engage = true")
    file.write_text(text.replace("console_required_s = 3.0", "console_required_s = 0.0"), "utf-8")
    trusted = TrustedKeys(out / "keys" / "remote")
    for name, role in (("second", Role.PARTNER), ("observer", Role.OBSERVER)):
        trusted.trust(name, create_keys(out / "keys" / name), role)
    create_keys(out / "keys" / "stranger")
    processes = SessionProcesses(out)
    attacked = Attacked(out, FaultSession(out, processes, configurations))
    with ExitStack() as opening:
        opening.callback(processes.end)
        opening.callback(attacked.end_attacks)
        for name, path in configurations.items():
            processes.start(name, path)
        attacked.session.wait_until_working(60.0)
        if console:
            attacked.page = opening.enter_context(opened(attacked.session.figures(CONSOLE)["address"]))
        yield attacked
