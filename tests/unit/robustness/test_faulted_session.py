"""A session in which a process has ended is reported as not working, so that the other findings are kept."""

from pathlib import Path
from typing import Any

import pytest

from common.link.curve import LinkProblem
from robustness.fault_session import FaultSession
from robustness.faulted_session import FaultedSession, NotWorking
from robustness.faults import recover
from teletaction.session.processes import SessionProcesses
from tests.ports import free_port


class Dead(FaultedSession):
    """A session whose sites have ended."""

    def __init__(self) -> None:
        self.time_s = 0.0

    def now_s(self) -> float:
        return self.time_s

    def wait(self, seconds: float) -> None:
        self.time_s += seconds

    def command(self, process: str, line: str) -> float:
        return self.time_s

    def mend(self) -> None:
        return

    def stop(self, process: str, seconds: float) -> tuple[float, float]:
        return self.time_s, self.time_s

    def ask(self, site: str, verb: str) -> dict[str, Any]:
        raise LinkProblem(f"{site}: no answer")

    def figures(self, process: str) -> dict[str, Any]:
        return {}


def test_a_session_whose_sites_have_ended_does_not_recover() -> None:
    assert not recover(Dead())


def test_a_simulation_that_has_ended_is_named(tmp_path: Path) -> None:
    session = FaultSession(tmp_path, SessionProcesses(tmp_path), {}, _ports={"sim-remote": free_port()})
    with pytest.raises(NotWorking, match=r"sim-remote: mend: .*refused"):
        session.command("sim-remote", "mend")


def test_a_simulation_that_cannot_be_mended_does_not_recover() -> None:
    class Unmended(Dead):
        def mend(self) -> None:
            raise NotWorking("sim-remote: mend: connection refused")

    assert not recover(Unmended())
