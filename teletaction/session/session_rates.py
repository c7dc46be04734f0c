"""Defines the rates of both sites' loops and selects those that a machine can hold."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from common.config.site_models import OperatorConfig, RemoteConfig
from common.runtime.machine import Machine
from common.timing.timeouts import FASTEST_RATE_HZ, SLOWEST_RATE_HZ

LARGEST = 0.7
"""Largest share of one processor for a process. A loop above it gives up its real-time priority."""
FITS = 0.65
"""Largest share of the idle processors for a session.

Sessions with a predicted share of 0.75 to 0.85 made 98 to 99 % of their ticks (`study rates`).
"""
BROWSER = 0.5
"""Number of processors that the browser of a console takes on the same machine."""


@dataclass(frozen=True, slots=True)
class Rates:
    """Loop rates of both sites, Hz."""

    remote_hz: float
    operator_hz: float

    def __str__(self) -> str:
        """Format the rates as `--rates` takes them."""
        return f"{self.remote_hz:g},{self.operator_hz:g}"

    @property
    def words(self) -> str:
        """Description of the rates for people."""
        return f"the remote site ticks {self.remote_hz:g} times a second, the operator site {self.operator_hz:g} times"

    @classmethod
    def read(cls, text: str) -> "Rates":
        """Parse `REMOTE,OPERATOR`, Hz.

        Raises:
            ValueError: the text is not two numbers, or a rate is out of range.
        """
        try:
            remote_hz, operator_hz = map(float, text.split(","))
        except ValueError:
            raise ValueError(f"--rates {text!r}: expected two numbers, REMOTE,OPERATOR, such as {DEFAULT}") from None
        for rate_hz in (remote_hz, operator_hz):
            if not SLOWEST_RATE_HZ <= rate_hz <= FASTEST_RATE_HZ:
                raise ValueError(f"--rates {text}: {rate_hz:g} is not {SLOWEST_RATE_HZ:g} to {FASTEST_RATE_HZ:g} Hz")
        return cls(remote_hz, operator_hz)


DEFAULT = Rates(RemoteConfig.model_fields["rate_hz"].default, OperatorConfig.model_fields["rate_hz"].default)
"""Default rates of the sites' configurations."""
FASTER = (Rates(1000.0, 1000.0), Rates(500.0, 500.0))
"""Faster rates in order of preference. A session takes the first that fits."""


class Cost(NamedTuple):
    """Processor time of a process with five fingers in contact, in reference steps per second and per tick."""

    second: float
    tick: float


COSTS: Mapping[str, Cost] = {
    "remote": Cost(1430.0, 4.15),
    "operator": Cost(690.0, 3.16),
    "sim-remote": Cost(2600.0, 0.0),
    "sim-operator": Cost(2000.0, 0.0),
}
"""Costs measured by `teletaction study rates`. The simulated devices run at a fixed rate."""


def taken(process: str, rate_hz: float, step_s: float) -> float:
    """Return the number of processors that a process takes at `rate_hz`, if a reference step takes `step_s` (s)."""
    cost = COSTS[process]
    return (cost.second + cost.tick * rate_hz) * step_s


def session_takes(rates: Rates, step_s: float) -> dict[str, float]:
    """Return the number of processors that each process of a session with simulated devices takes."""
    hz = {"remote": rates.remote_hz, "operator": rates.operator_hz}
    return {process: taken(process, hz.get(process, 0.0), step_s) for process in COSTS}


def fitting_here(console: bool) -> Rates:
    """Return the rates for a session on this machine now; DEFAULT if the machine cannot be measured."""
    try:
        return fitting_rates(Machine.measured(), BROWSER if console else 0.0)
    except OSError:
        return DEFAULT


def fitting_rates(machine: Machine, others: float = 0.0) -> Rates:
    """Return the fastest rates that a session with five fingers holds on a machine; DEFAULT if no faster ones fit.

    `others` is the number of processors that other work will take.
    """
    for rates in FASTER:
        takes = session_takes(rates, machine.step_s).values()
        if max(takes) <= LARGEST and sum(takes) + others <= FITS * machine.idle:
            return rates
    return DEFAULT
