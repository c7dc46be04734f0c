"""Base of the sessions into which faults are injected: of real processes, and on the test bed."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from common.faults.texts import said_fault
from common.link.session_state import Refused

WORKING_S = 30.0
_COOL_S = 20.0
_SLOW_STOPPED_S, _SLOW_RUNNING_S = 0.030, 0.010


class NotWorking(RuntimeError):
    """A session does not start to work, or refuses a command; the message says why."""


class FaultedSession(ABC):
    """Both sites and all simulated devices.

    Attributes:
        settled_s: time for which a session works before the next fault, s.
    """

    settled_s: ClassVar[float] = 1.0

    @abstractmethod
    def now_s(self) -> float:
        """Time of the session, s, on the same clock as its recordings."""

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Wait for `seconds` of the session's time."""

    @abstractmethod
    def command(self, process: str, line: str) -> float:
        """Make a simulation fail, or mend it; returns when that took effect, s.

        Raises:
            NotWorking: the simulation refuses the command.
        """

    @abstractmethod
    def mend(self) -> None:
        """End every fault."""

    @abstractmethod
    def stop(self, process: str, seconds: float) -> tuple[float, float]:
        """Halt a process for `seconds`; returns when that began and ended, s."""

    def slow(self, process: str, seconds: float) -> tuple[float, float]:
        """Run a process in slices of 10 ms with 30 ms pauses; returns when that began and ended, s."""
        begin_s = self.now_s()
        while self.now_s() < begin_s + seconds:
            self.stop(process, _SLOW_STOPPED_S)
            self.wait(_SLOW_RUNNING_S)
        return begin_s, self.now_s()

    @abstractmethod
    def ask(self, site: str, verb: str) -> dict[str, Any]:
        """Send a request to the desk of a site, as a person there would.

        Raises:
            LinkProblem, Refused: the site does not answer, or refuses.
        """

    @abstractmethod
    def figures(self, process: str) -> dict[str, Any]:
        """Newest status of a process; empty before the first."""

    def states(self) -> dict[str, str]:
        """State of each site, with the fault or refusal behind it."""
        said = {}
        for site in ("remote", "operator"):
            try:
                answer = self.ask(site, "status")
            except (Refused, OSError) as error:
                said[site] = f"silent: {error}"
            else:
                why = said_fault(answer.get("fault")) or answer.get("missing") or answer.get("refusal")
                said[site] = answer["state"] + (f": {why}" if why else "")
        return said

    def wait_until_working(self, seconds: float = WORKING_S) -> None:
        """Wait until both sites are engaged and act on fresh data, the hand has worked, and this has lasted for
        `settled_s`.

        Raises:
            NotWorking: this does not happen within `seconds`.
        """
        begin_s = self.now_s()
        since_s = None
        while self.now_s() < begin_s + seconds:
            if (
                all(state == "engaged" for state in self.states().values())
                and self.acts_since(begin_s)
                and float(self.figures("sim-operator").get("script_s") or 0.0) > 2.0
            ):
                since_s = since_s or self.now_s()
                if self.now_s() - since_s > self.settled_s:
                    return
            else:
                since_s = None
            self.wait(0.05)
        raise NotWorking(f"not working after {seconds:g} s: {self.states()}")

    def acts_since(self, begin_s: float) -> bool:
        """Whether reports newer than `begin_s` show that both sites act on fresh data and the remote hand has arrived.

        A site stays engaged while nothing reaches it, and then its hand has to catch up. Each site reports once a
        second.
        """
        said = {site: self.figures(site) for site in ("remote", "operator")}
        if any(each.get("time_ns", 0) * 1e-9 < begin_s or each.get("stale") for each in said.values()):
            return False
        limited: dict[str, list[str]] = said["remote"].get("limited") or {}
        return not any("approach" in limits for limits in limited.values())

    def clear_and_engage(self) -> None:
        """Clear the latched faults of each site and engage, as a person does; retry while something is hot."""
        end_s = self.now_s() + _COOL_S
        while self.now_s() < end_s:
            try:
                for site in ("remote", "operator"):
                    if self.states()[site].startswith("fault"):
                        self.ask(site, "clear_fault")
                self.ask("operator", "engage")
            except (Refused, OSError):
                pass  # the other site's report of the clearing is still in flight, or a site has ended
            self.wait(0.5)
            if all(state == "engaged" for state in self.states().values()):
                return
