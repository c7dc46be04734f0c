"""What is common to sessions to which faults are done: of real processes, and on the test bed."""

from abc import ABC, abstractmethod
from typing import Any

from common.curve_sockets import LinkProblem
from common.session import Refused

_WORKING_S = 30.0
_COOL_S = 20.0
_SLOW_STOPPED_S, _SLOW_RUNNING_S = 0.030, 0.010


class NotWorking(RuntimeError):
    """A session that does not come to work; the message says what its sites say."""


class FaultedSession(ABC):
    """Both sites and all simulated devices."""

    @abstractmethod
    def now_s(self) -> float:
        """Time of the session, s; its recordings have the same."""

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Let time pass."""

    @abstractmethod
    def command(self, process: str, line: str) -> float:
        """Let a simulation fail, or be sound again; returns when it did, s.

        Raises:
            NotWorking: it does not understand.
        """

    @abstractmethod
    def mend(self) -> None:
        """End every fault."""

    @abstractmethod
    def stop(self, process: str, seconds: float) -> tuple[float, float]:
        """Let a process stand still for some time; returns when that began and ended, s."""

    def slow(self, process: str, seconds: float) -> tuple[float, float]:
        """Let a process run in slices of 10 ms with 30 ms between; returns when that began and ended, s."""
        begin_s = self.now_s()
        while self.now_s() < begin_s + seconds:
            self.stop(process, _SLOW_STOPPED_S)
            self.wait(_SLOW_RUNNING_S)
        return begin_s, self.now_s()

    @abstractmethod
    def ask(self, site: str, verb: str) -> dict[str, Any]:
        """Ask at the desk of a site, as a person there would.

        Raises:
            LinkProblem, Refused: nobody answers, or it will not.
        """

    @abstractmethod
    def figures(self, process: str) -> dict[str, Any]:
        """What a process last said of itself; empty before the first."""

    def states(self) -> dict[str, str]:
        """What both sites say of their state, with the fault or refusal behind it."""
        said = {}
        for site in ("remote", "operator"):
            try:
                answer = self.ask(site, "status")
            except (LinkProblem, Refused, OSError) as error:
                said[site] = f"silent: {error}"
            else:
                why = answer.get("fault") or answer.get("missing") or answer.get("refusal")
                said[site] = answer["state"] + (f": {why}" if why else "")
        return said

    def wait_until_working(self, seconds: float = _WORKING_S) -> None:
        """Return once both sites are engaged and act on each other, and the hand has worked for a while since.

        Raises:
            NotWorking: they do not become so in time.
        """
        begin_s = self.now_s()
        since_s = None
        while self.now_s() < begin_s + seconds:
            if (
                all(state == "engaged" for state in self.states().values())
                and self._acts_since(begin_s)
                and float(self.figures("sim-operator").get("script_s") or 0.0) > 2.0
            ):
                since_s = since_s or self.now_s()
                if self.now_s() - since_s > 1.0:
                    return
            else:
                since_s = None
            self.wait(0.05)
        raise NotWorking(f"not working after {seconds:g} s: {self.states()}")

    def _acts_since(self, begin_s: float) -> bool:
        """Whether both sites, by words of theirs from after `begin_s`, act on what is fresh and the hand has come.

        A site stays engaged while nothing reaches it, and then its hand has a way to go; each says so once a second.
        """
        said = {site: self.figures(site) for site in ("remote", "operator")}
        if any(each.get("time_ns", 0) * 1e-9 < begin_s or each.get("stale") for each in said.values()):
            return False
        limited: dict[str, list[str]] = said["remote"].get("limited") or {}
        return not any("approach" in limits for limits in limited.values())

    def clear_and_engage(self) -> None:
        """What a person does after a latched fault, at each site that has one; again, while something is hot."""
        end_s = self.now_s() + _COOL_S
        while self.now_s() < end_s:
            try:
                for site in ("remote", "operator"):
                    if self.states()[site].startswith("fault"):
                        self.ask(site, "clear_fault")
                self.ask("operator", "engage")
            except Refused:
                pass  # the other site's word of it is still under way
            self.wait(0.5)
            if all(state == "engaged" for state in self.states().values()):
                return
