"""A session in lock step to which faults of devices are done: each tick is on time, whatever the machine does."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from common.config import load_site
from common.desk import ask_desk
from common.keys import load_keys
from studies.fault_session import prepare_session
from studies.faulted_session import FaultedSession, NotWorking
from teletaction.testbed.devices import SimulatedDevices
from teletaction.testbed.lockstep import LockStep, sites


@dataclass(slots=True)
class LockStepSession(FaultedSession):
    """Both sites and all devices in this process; time is virtual, lines and link are real."""

    lockstep: LockStep
    devices: SimulatedDevices
    configurations: dict[str, Path]
    person: ThreadPoolExecutor

    @classmethod
    @contextmanager
    def open(cls, out: Path) -> "Iterator[LockStepSession]":
        """Engage a session that is recorded in `out`, and end it again.

        Raises:
            NotEngaged: the sites did not find their devices or each other.
        """
        configurations, lockstep = prepare_session(out), LockStep()
        with ExitStack() as opened:
            devices = SimulatedDevices(configurations, lockstep.now_s)
            opened.callback(devices.close)
            opened.enter_context(sites(lockstep, configurations))
            lockstep.engage(devices)
            person = opened.enter_context(ThreadPoolExecutor(1))
            yield cls(lockstep, devices, configurations, person)

    def now_s(self) -> float:
        """Virtual time, s."""
        return self.lockstep.time_s

    def wait(self, seconds: float) -> None:
        """Let virtual time pass."""
        end_s = self.lockstep.time_s + seconds
        while self.lockstep.time_s < end_s:
            self.lockstep.tick(self.devices)

    def command(self, process: str, line: str) -> float:
        """Let a simulation fail, or be sound again; returns when it did, s.

        Raises:
            NotWorking: it does not understand.
        """
        devices = self.devices.remote if process == "sim-remote" else self.devices.operator
        try:
            devices.faults.apply(line)
        except ValueError as error:
            raise NotWorking(f"{process}: {line}: {error}") from None
        return self.lockstep.time_s

    def mend(self) -> None:
        """End every fault of a device."""
        for name in ("sim-remote", "sim-operator"):
            self.command(name, "mend")

    def ask(self, site: str, verb: str) -> dict[str, Any]:
        """Ask at the desk of a site, as a person there would, while time goes on.

        Raises:
            LinkProblem, Refused: nobody answers, or it will not.
        """
        config = load_site(self.configurations[site])
        answer = self.person.submit(ask_desk, config.desk_port, load_keys(config.link.keys), verb)
        while not answer.done():
            self.lockstep.tick(self.devices)
        return answer.result()

    def figures(self, process: str) -> dict[str, Any]:
        """What a process says of itself now."""
        match process:
            case "remote":
                figures = self.lockstep.remote.figures()
            case "operator":
                figures = self.lockstep.operator.figures()
            case _:
                figures = self.devices.operator.figures()
        return {"time_ns": self.lockstep.now_ns(), **figures}
