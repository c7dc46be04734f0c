"""Resolves the name of the remote site's host in a thread of its own.

libzmq resolves names in the thread that serves all sockets. A name server that does not answer would stop them for
10 s.
"""

import ipaddress
import logging
import socket
import threading

from common.files.printable import printable

log = logging.getLogger(__name__)

look_up = socket.getaddrinfo
AGAIN_S = 5.0
"""Interval between two name look-ups, s."""
_ANSWER_S = 1.0
"""Maximum wait for a connection to one of several addresses, s."""


def bare_host(host: str) -> str:
    """Return a host without the brackets that IPv6 addresses have before a port."""
    return host[1:-1] if host.startswith("[") and host.endswith("]") else host


def is_ipv6(host: str) -> bool:
    """Return whether a host is an IPv6 address, with or without brackets."""
    return ":" in host


def is_loopback(host: str) -> bool:
    """Return whether a name, or an address without brackets, is of the loopback interface."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def bracketed(host: str) -> str:
    """Return a bare host as it stands before a port: an IPv6 address in brackets."""
    return f"[{host}]" if is_ipv6(host) else host


def tcp_endpoint(host: str, port: int) -> str:
    """Return the address of a socket in libzmq's form."""
    return f"tcp://{bracketed(bare_host(host))}:{port}"


class Resolver:
    """Holds the newest good address of a host; resolves it every AGAIN_S in a thread of its own."""

    def __init__(self, host: str, port: int):
        """Start resolving; a numeric address needs no look-up.

        Args:
            host: name or address.
            port: TCP port of the remote site. Where a name has several addresses, this port is tried.
        """
        self.address: str | None = None
        """Numeric address; None until the name server has answered once."""
        self.problem = ""
        """Reason why the last look-up failed; empty where it succeeded."""
        self._host, self._port = bare_host(host), port
        self._end = threading.Event()
        try:
            ipaddress.ip_address(self._host)
        except ValueError:
            threading.Thread(target=self._run, name="resolver", daemon=True).start()
        else:
            self.address = self._host

    def close(self) -> None:
        """End the thread after the look-up under way."""
        self._end.set()

    def _run(self) -> None:
        while not self._end.is_set():
            try:
                found = look_up(self._host, self._port, type=socket.SOCK_STREAM)
                self.address = self._best([str(answer[4][0]) for answer in found])
                self._notice("")
            except (OSError, UnicodeError) as error:  # UnicodeError: not a valid host name
                self._notice(printable(f"{self._host}: {error}", 200))
            self._end.wait(AGAIN_S)

    def _notice(self, problem: str) -> None:
        """Log a new problem once."""
        if problem and problem != self.problem:
            log.warning("no address: %s", problem)
        self.problem = problem

    def _best(self, found: list[str]) -> str | None:
        """Return the present address while it answers, which keeps the session; else one of `found` that answers."""
        candidates = list(dict.fromkeys(([self.address] if self.address else []) + found))
        if len(candidates) < 2:
            return candidates[0] if candidates else None
        return next((address for address in candidates if self._answers(address)), found[0] if found else None)

    def _answers(self, address: str) -> bool:
        try:
            with socket.create_connection((address, self._port), timeout=_ANSWER_S):
                return True
        except OSError:
            return False
