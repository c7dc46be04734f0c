"""Waits after an emergency stop until all devices confirm that their outputs are off."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from common.limits import THERMAL_SAFE_S

PATIENCE_NS = round(1.5 * THERMAL_SAFE_S * 1e9)
"""Maximum wait for confirmations, ns; then unconfirmed devices are named. All outputs are off in two thirds of it."""

Unconfirmed = Callable[[float], Mapping[str, str]]
"""Returns for each device why its outputs may not be off since a time, s; empty where they certainly are."""


@dataclass(frozen=True, slots=True)
class Confirmation:
    """Result of an emergency stop."""

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
    """Time of the last request for a stop, ns; None without one, or when its outputs may be on again."""
    after_s: dict[str, float | None] = field(default_factory=dict)
    """Time from the request to each device's confirmation, s; None without one. A late one counts, too."""
    _waiting: bool = False

    def ask(self, now_ns: int) -> None:
        """Start a stop; one that still waits for confirmations continues."""
        if not self._waiting:
            self.asked_ns, self.after_s, self._waiting = now_ns, {}, True

    def forget(self) -> None:
        """Forget the stop when the fault is cleared: outputs may be on again. A stop that still waits is kept."""
        if self.asked_ns is not None and not self._waiting:
            self.asked_ns, self.after_s = None, {}

    def step(self, now_ns: int, unconfirmed: Unconfirmed) -> Confirmation | None:
        """Return the result once, as soon as it is known; `unconfirmed` gets the time of the stop, ns."""
        if self.asked_ns is None or now_ns <= self.asked_ns:
            return None
        if not self._waiting and None not in self.after_s.values():
            return None
        why = unconfirmed(self.asked_ns * 1e-9)
        after_s = (now_ns - self.asked_ns) * 1e-9
        for device, reason in why.items():
            if reason:
                self.after_s[device] = None
            elif self.after_s.get(device) is None:
                self.after_s[device] = after_s
        missing = "; ".join(f"{device}: {reason}" for device, reason in why.items() if reason)
        if not self._waiting or (missing and now_ns - self.asked_ns < PATIENCE_NS):
            return None
        self._waiting = False
        return Confirmation(after_s, missing)
