"""Reads, writes and opens the address of a CAN bus."""

import re
from typing import Literal

import can
from pydantic import Field, ValidationError, field_validator

from common.buses.serial_port import DeviceAbsent
from common.buses.socketcand_bus import GatewayBus
from common.files.strict_model import StrictModel
from common.link.host_name import is_ipv6

_GATEWAY = re.compile(r"socketcand://(?P<host>\[[^\]]*\]|[^:/]+):(?P<port>\d{1,5})/(?P<channel>[\w.-]+)")
_LOCAL = re.compile(r"\w+:(?P<channel>[\w .-]+)")


class CanAddress(StrictModel):
    """Address of a CAN bus: `socketcan` for hardware, `socketcand` for a gateway, `virtual` within one process."""

    interface: Literal["socketcan", "socketcand", "virtual"]
    channel: str = "can0"
    host: str = "127.0.0.1"
    port: int = Field(default=29536, ge=1, le=65535)

    @field_validator("host")
    @classmethod
    def _not_ipv6(cls, host: str) -> str:
        if is_ipv6(host):
            raise ValueError("a CAN gateway needs a name or an IPv4 address: python-can has no IPv6")
        return host

    def __str__(self) -> str:
        if self.interface == "socketcand":
            return f"{self.interface}://{self.host}:{self.port}/{self.channel}"
        return f"{self.interface}:{self.channel}"

    def open(self) -> can.BusABC:
        """Open the bus, which may block for a moment; raises DeviceAbsent where it cannot be opened."""
        try:
            if self.interface == "socketcand":
                return GatewayBus(self.channel, self.host, self.port)
            return can.Bus(interface=self.interface, channel=self.channel)
        except (can.CanError, OSError) as error:
            raise DeviceAbsent(f"CAN {self}: {error}") from None


def can_address(text: str) -> CanAddress | None:
    """Return the CAN address from its text, as `str(CanAddress)` writes it; None for another kind of address.

    Raises:
        ValueError: the text begins as a CAN address and is none.
    """
    interface = next((each for each in ("socketcand", "socketcan", "virtual") if text.startswith(f"{each}:")), None)
    if interface is None:
        return None
    found = _GATEWAY.fullmatch(text) if interface == "socketcand" else _LOCAL.fullmatch(text)
    if found is None:
        raise ValueError(f"{text}: a CAN bus is socketcan:CHANNEL or socketcand://HOST:PORT/CHANNEL")
    try:
        return CanAddress.model_validate({"interface": interface, **found.groupdict()})
    except ValidationError as error:
        problem = error.errors()[0]
        raise ValueError(f"{text}: {problem['loc'][0]}: {problem['msg'].removeprefix('Value error, ')}") from None
