"""Decides where a server of a running session listens: on loopback, unless a person opens it to a network."""

import ipaddress
import socket
from typing import NamedTuple

LOOPBACK = "127.0.0.1"


class Place(NamedTuple):
    """Where a server listens, and whose session it serves.

    Attributes:
        site: fingerprint of the operator site's key; the same after each restart.
        host: IP address.
        port: port; unused by a tool that chooses its own.
    """

    site: str
    host: str = LOOPBACK
    port: int = 0

    @property
    def url_host(self) -> str:
        """The address as part of a URL."""
        return f"[{self.host}]" if ":" in self.host else self.host


def listening_place(site: str, host: str, port: int, *, open_to_network: bool) -> Place:
    """Return a place with a free port.

    Args:
        site: fingerprint of the operator site's key.
        host: IP address, or `localhost`.
        port: port; 0 takes a free one.
        open_to_network: whether other hosts may read the session.

    Raises:
        ValueError: `host` is no IP address, or it is open to a network and `open_to_network` is False.
        OSError: the port is in use, or the address does not belong to this machine.
    """
    try:
        address = ipaddress.ip_address(LOOPBACK if host == "localhost" else host)
    except ValueError:
        raise ValueError(f"--host {host}: expected an IP address, such as {LOOPBACK}") from None
    if not address.is_loopback and not open_to_network:
        raise ValueError(
            f"--host {host} is open to a network, and readers need no key: allow that with --open-to-network, "
            "or leave out --host"
        )
    family = socket.AF_INET6 if address.version == 6 else socket.AF_INET
    try:
        with socket.create_server((str(address), port), family=family) as found:
            return Place(site, str(address), found.getsockname()[1])
    except OSError as error:
        raise OSError(f"{host}:{port}: {error.strerror}; choose another --port") from None
