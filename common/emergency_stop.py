"""An emergency stop is done when the output drivers say so, not when it was asked for."""

from collections.abc import Callable
from dataclasses import dataclass

from common.limits import THERMAL_SAFE_S

PATIENCE_NS = round(1.5 * THERMAL_SAFE_S * 1e9)
"""The slowest output is off within two thirds of this; who has not confirmed by then is named."""


@dataclass(frozen=True, slots=True)
class Confirmation:
    """How an emergency stop ended."""

    after_s: float
    unconfirmed: str
    """Devices that did not report their outputs off; empty when all did."""

    def __str__(self) -> str:
        if self.unconfirmed:
            return f"stopped, but not confirmed within {self.after_s * 1e3:.0f} ms by {self.unconfirmed}"
        return f"stopped, confirmed by every device after {self.after_s * 1e3:.0f} ms"


@dataclass(slots=True)
class EmergencyStop:
    """Waits for the devices of one site to confirm. Pure: time is an argument, ns."""

    asked_ns: int | None = None

    def ask(self, now_ns: int) -> None:
        """A stop was asked for; one that is already waited for goes on."""
        if self.asked_ns is None:
            self.asked_ns = now_ns

    def step(self, now_ns: int, unconfirmed: Callable[[float], str]) -> Confirmation | None:
        """The outcome, once, as soon as it is known.

        Args:
            now_ns: this site's clock.
            unconfirmed: says which devices have not reported since a time (s) that their outputs are off.
        """
        if self.asked_ns is None or now_ns <= self.asked_ns:
            return None
        missing = unconfirmed(self.asked_ns * 1e-9)
        if missing and now_ns - self.asked_ns < PATIENCE_NS:
            return None
        after_s = (now_ns - self.asked_ns) * 1e-9
        self.asked_ns = None
        return Confirmation(after_s, missing)
