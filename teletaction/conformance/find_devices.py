"""Find the devices that are connected to this host, independent of a configuration."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from common.buses.can_address import CanAddress
from common.buses.serial_device import open_line, plain_name
from common.buses.serial_messages import Identity
from common.buses.serial_port import DeviceAbsent
from common.fingers import FINGERS
from teletaction.conformance.node_talk import BusEnd, name_of

PORTS = Path("/dev/serial/by-id")
"""Folder of serial ports under names that are independent of the socket that they are plugged into."""
NETWORK = Path("/sys/class/net")
_CAN_INTERFACE = "280"
"""Interface type of CAN, ARPHRD_CAN in Linux `if_arp.h`."""


@dataclass(frozen=True, slots=True)
class Found:
    """An address, and the device that answered there or the reason why none did."""

    address: str
    good: bool
    words: str
    identity: Identity | None = None


def find_modules(ports: Path = PORTS) -> Iterator[Found]:
    """Ask the module at each port of a folder for its identity: seven bytes to each, and a second of patience."""
    for port in sorted(ports.iterdir()) if ports.is_dir() else ():
        try:
            opened = open_line(str(port))
        except DeviceAbsent as error:
            yield Found(str(port), False, str(error).removeprefix(f"{port}: "))
            continue
        opened.port.close()
        yield Found(str(port), True, in_words(opened.identity), opened.identity)


def find_nodes() -> Iterator[Found]:
    """Listen on each CAN interface of the host, and yield the node that sends there."""
    for name in can_interfaces():
        address = CanAddress(interface="socketcan", channel=name)
        try:
            require_interface(address)
            end = BusEnd(address)
            try:
                yield Found(str(address), True, name_of(end))
            finally:
                end.close()
        except DeviceAbsent as error:
            yield Found(str(address), False, str(error).removeprefix(f"CAN {address}: "))


def can_interfaces(network: Path = NETWORK) -> dict[str, bool]:
    """Return the host's CAN interfaces, and whether each is up."""
    if not network.is_dir():
        return {}
    kinds = {each.name: _read(each / "type") for each in sorted(network.iterdir())}
    return {
        name: _read(network / name / "operstate") != "down" for name, kind in kinds.items() if kind == _CAN_INTERFACE
    }


def require_interface(address: CanAddress, network: Path = NETWORK) -> None:
    """Check an interface of this host before it is opened.

    Raises:
        DeviceAbsent: no interface has that name, or it is down.
    """
    if address.interface != "socketcan" or (is_up := can_interfaces(network).get(address.channel)):
        return
    problem = "is no CAN interface of this host" if is_up is None else "is down"
    raise DeviceAbsent(f"CAN {address}: {address.channel} {problem}: deploy/network/README.md brings it up at 1 Mbit/s")


def in_words(identity: Identity) -> str:
    """Describe a device: finger if it has one, kind, serial number and firmware."""
    name = plain_name(identity.kind, FINGERS[identity.finger])
    return f"{name}, serial number {identity.serial}, firmware {identity.firmware}"


def _read(file: Path) -> str:
    try:
        return file.read_text("ascii").strip()
    except OSError:
        return ""
