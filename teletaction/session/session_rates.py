"""Rates of both sites' loops, and which of them a machine can hold."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from common.config import OperatorConfig, RemoteConfig
from common.runtime.machine import Machine
from common.timing.timeouts import FASTEST_RATE_HZ, SLOWEST_RATE_HZ

LARGEST = 0.7
"""Share of one processor that a process may take at most: a loop that works more gives its priority up."""
FITS = 0.65
"""Share of the idle processors that a session may take at most. Sessions that were to take 0.75 to 0.85 of them made
98 to 99 % of their ticks (`study rates`)."""
BROWSER = 0.5
"""Processors that the browser of a console takes on the same machine."""


@dataclass(frozen=True, slots=True)
class Rates:
    """Ticks a second of both sites."""

    remote_hz: float
    operator_hz: float

    def __str__(self) -> str:
        """As `--rates` takes it."""
        return f"{self.remote_hz:g},{self.operator_hz:g}"

    @property
    def words(self) -> str:
        """For a person."""
        return f"the remote site ticks {self.remote_hz:g} times a second, the operator site {self.operator_hz:g} times"

    @classmethod
    def read(cls, text: str) -> "Rates":
        """From `REMOTE,OPERATOR`, Hz; raises ValueError."""
        try:
            remote_hz, operator_hz = map(float, text.split(","))
        except ValueError:
            raise ValueError(f"--rates {text!r}: expected two numbers, REMOTE,OPERATOR, such as {DEFAULT}") from None
        for rate_hz in (remote_hz, operator_hz):
            if not SLOWEST_RATE_HZ <= rate_hz <= FASTEST_RATE_HZ:
                raise ValueError(f"--rates {text}: {rate_hz:g} is not {SLOWEST_RATE_HZ:g} to {FASTEST_RATE_HZ:g} Hz")
        return cls(remote_hz, operator_hz)


DEFAULT = Rates(RemoteConfig.model_fields["rate_hz"].default, OperatorConfig.model_fields["rate_hz"].default)
"""What a site has whose configuration says nothing of its rate."""
FASTER = (Rates(1000.0, 1000.0), Rates(500.0, 500.0))
"""Rates that a session has instead where they fit, the first that does."""


class Cost(NamedTuple):
    """Processor time of a process with five fingers in contact, in reference steps: each second, and each tick."""

    second: float
    tick: float


COSTS: Mapping[str, Cost] = {
    "remote": Cost(1430.0, 4.15),
    "operator": Cost(690.0, 3.16),
    "sim-remote": Cost(2600.0, 0.0),
    "sim-operator": Cost(2000.0, 0.0),
}
"""As `teletaction study rates` measures them; the simulated devices have a rate of their own."""


def taken(process: str, rate_hz: float, step_s: float) -> float:
    """Processors that a process takes at a rate, where a reference step takes `step_s` seconds."""
    cost = COSTS[process]
    return (cost.second + cost.tick * rate_hz) * step_s


def session_takes(rates: Rates, step_s: float) -> dict[str, float]:
    """Processors that each process of a session with simulated devices takes."""
    hz = {"remote": rates.remote_hz, "operator": rates.operator_hz}
    return {process: taken(process, hz.get(process, 0.0), step_s) for process in COSTS}


def fitting_here(console: bool) -> Rates:
    """The rates for a session on this machine now, with a console or without; DEFAULT where it cannot be measured."""
    try:
        return fitting_rates(Machine.measured(), BROWSER if console else 0.0)
    except OSError:
        return DEFAULT


def fitting_rates(machine: Machine, others: float = 0.0) -> Rates:
    """The fastest rates that a session with five fingers holds on a machine; DEFAULT where none faster do.

    Args:
        machine: as it is now.
        others: processors that something else will take.
    """
    for rates in FASTER:
        takes = session_takes(rates, machine.step_s).values()
        if max(takes) <= LARGEST and sum(takes) + others <= FITS * machine.idle:
            return rates
    return DEFAULT
