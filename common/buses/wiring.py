"""Interface between a site and its devices: ports, buses and openers that run beside the loop.

`SYSTEM` uses the hardware of the host. A test bed provides lines in memory and virtual time instead.
"""

from collections.abc import Callable
from typing import Protocol, TypeVar

import can

from common.buses.background_opener import BackgroundOpener
from common.buses.can_address import CanAddress
from common.buses.serial_port import Port, open_port

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Opener(Protocol[T_co]):
    """Opens one device without blocking the loop and repeats until it succeeds."""

    problem: Exception | None
    """Reason why the last attempt failed; None while no attempt has failed."""

    def start(self) -> None:
        """Start opening; does nothing while an attempt is under way."""

    def take(self) -> T_co | None:
        """Return the opened device once; None while there is no new one."""

    def stop(self) -> None:
        """Stop opening."""


class Wiring(Protocol):
    """Connection between a site and its devices."""

    def open_port(self, address: str) -> Port:
        """Open a serial line; raises DeviceAbsent where there is no device, or another program uses it."""

    def open_bus(self, address: CanAddress) -> can.BusABC:
        """Open a CAN bus; raises DeviceAbsent."""

    def opener(self, opens: Callable[[], T], discard: Callable[[T], object]) -> Opener[T]:
        """Return an opener that calls `opens`; `discard` closes a device that is no longer needed."""


class SystemWiring:
    """Uses the operating system's lines and opens them in threads."""

    def open_port(self, address: str) -> Port:
        """As `Wiring.open_port`."""
        return open_port(address)

    def open_bus(self, address: CanAddress) -> can.BusABC:
        """As `Wiring.open_bus`."""
        return address.open()

    def opener(self, opens: Callable[[], T], discard: Callable[[T], object]) -> Opener[T]:
        """As `Wiring.opener`."""
        return BackgroundOpener(opens, discard=discard)


SYSTEM: Wiring = SystemWiring()
