"""How a site reaches its devices: ports, buses, and how they are opened beside the loop.

`SYSTEM` is that of the machine that a site runs on. A test bed gives a site lines in memory and virtual time instead.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar

import can

from common.buses.background_opener import BackgroundOpener
from common.buses.serial_port import Port, open_port

if TYPE_CHECKING:
    from common.buses.can_port import CanAddress

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Opener(Protocol[T_co]):
    """Opens one device, again and again until it succeeds, without holding the loop up."""

    problem: Exception | None
    """Why the last try failed; None while none has."""

    def start(self) -> None:
        """Begin trying; does nothing while a try is under way."""

    def take(self) -> T_co | None:
        """What was opened, once; None while there is nothing new."""

    def stop(self) -> None:
        """Give up."""


class Wiring(Protocol):
    """What lies between a site and its devices."""

    def open_port(self, address: str, baud: int) -> Port:
        """Open a serial line.

        Raises:
            DeviceAbsent: nothing is there, or another program has it.
        """

    def open_bus(self, address: "CanAddress") -> can.BusABC:
        """Open a CAN bus; raises DeviceAbsent."""

    def opener(self, opens: Callable[[], T], discard: Callable[[T], object]) -> Opener[T]:
        """An opener that calls `opens`; `discard` closes what was opened and is wanted no more."""


class SystemWiring:
    """The operating system's own lines, opened by threads."""

    def open_port(self, address: str, baud: int) -> Port:
        """As `Wiring.open_port`."""
        return open_port(address, baud)

    def open_bus(self, address: "CanAddress") -> can.BusABC:
        """As `Wiring.open_bus`."""
        return address.open()

    def opener(self, opens: Callable[[], T], discard: Callable[[T], object]) -> Opener[T]:
        """As `Wiring.opener`."""
        return BackgroundOpener(opens, discard=discard)


SYSTEM: Wiring = SystemWiring()
