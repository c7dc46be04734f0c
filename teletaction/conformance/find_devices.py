"""Which devices there are on this host, whatever a configuration says."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from common.buses.can_port import CanAddress
from common.buses.serial_device import open_line
from common.buses.serial_messages import Identity
from common.buses.serial_port import DeviceAbsent
from common.fingers import FINGERS
from teletaction.conformance.node_talk import BusEnd, name_of

PORTS = Path("/dev/serial/by-id")
"""Serial ports under names that stay the same wherever they are plugged in."""
NETWORK = Path("/sys/class/net")
_CAN_INTERFACE = "280"
"""Linux, if_arp.h."""


@dataclass(frozen=True, slots=True)
class Found:
    """Something that answered, or why nothing did."""

    address: str
    good: bool
    words: str
    identity: Identity | None = None


def find_modules(ports: Path = PORTS) -> Iterator[Found]:
    """Ask whatever is at the ports of a folder who it is: seven bytes to each, and a second of patience."""
    for port in sorted(ports.iterdir()) if ports.is_dir() else ():
        try:
            opened = open_line(str(port))
        except DeviceAbsent as error:
            yield Found(str(port), False, str(error).removeprefix(f"{port}: "))
            continue
        opened.port.close()
        yield Found(str(port), True, in_words(opened.identity), opened.identity)


def find_nodes(network: Path = NETWORK) -> Iterator[Found]:
    """Listen which node is on each CAN interface of the host."""
    for name in can_interfaces(network):
        address = CanAddress(interface="socketcan", channel=name)
        try:
            require_interface(address, network)
            end = BusEnd(address)
            try:
                yield Found(str(address), True, name_of(end))
            finally:
                end.close()
        except DeviceAbsent as error:
            yield Found(str(address), False, str(error).removeprefix(f"CAN {address}: "))


def can_interfaces(network: Path = NETWORK) -> dict[str, bool]:
    """The host's CAN interfaces, and whether each is up."""
    if not network.is_dir():
        return {}
    kinds = {each.name: _read(each / "type") for each in sorted(network.iterdir())}
    return {
        name: _read(network / name / "operstate") != "down" for name, kind in kinds.items() if kind == _CAN_INTERFACE
    }


def require_interface(address: CanAddress, network: Path = NETWORK) -> None:
    """Say what is wrong with an interface of this host before anybody tries to open it.

    Raises:
        DeviceAbsent: there is none of that name, or it is down.
    """
    if address.interface != "socketcan" or (is_up := can_interfaces(network).get(address.channel)):
        return
    problem = "is no CAN interface of this host" if is_up is None else "is down"
    raise DeviceAbsent(f"CAN {address}: {address.channel} {problem}: deploy/network/README.md brings it up at 1 Mbit/s")


def in_words(identity: Identity) -> str:
    """Whose device of which kind it is."""
    kind = identity.kind.name.lower().replace("_", " ")
    return f"{FINGERS[identity.finger]} {kind}, serial number {identity.serial}, firmware {identity.firmware}"


def _read(file: Path) -> str:
    try:
        return file.read_text("ascii").strip()
    except OSError:
        return ""
