"""Resolves the name of the remote site's host in a thread of its own, never in the link.

libzmq asks the name server in the thread that serves all sockets: one that does not answer stops them all for 10 s.
"""

import ipaddress
import logging
import socket
import threading

from common.files.printable import printable

log = logging.getLogger(__name__)

look_up = socket.getaddrinfo
AGAIN_S = 5.0
"""Time between two questions to the name server, s."""
_ANSWER_S = 1.0
"""An address of several that accepts no connection within this time is passed over, s."""


def bare_host(host: str) -> str:
    """An address or name without the brackets that IPv6 addresses have beside a port."""
    return host[1:-1] if host.startswith("[") and host.endswith("]") else host


def is_ipv6(host: str) -> bool:
    """Whether a host is given by its IPv6 address, with or without brackets."""
    return ":" in host


def tcp_endpoint(host: str, port: int) -> str:
    """Address of a socket as libzmq writes it."""
    bare = bare_host(host)
    return f"tcp://[{bare}]:{port}" if is_ipv6(bare) else f"tcp://{bare}:{port}"


class Resolver:
    """Knows the newest good address of a host; asks every AGAIN_S in a thread of its own."""

    def __init__(self, host: str, port: int):
        """Begin asking; for a numeric address nobody is asked.

        Args:
            host: name or address.
            port: TCP port at which the remote site listens. Where a name has several addresses, this port is tried.
        """
        self.address: str | None = None
        """Numeric address; None until the name server has answered for the first time."""
        self.problem = ""
        """Why the last question had no answer; empty where it had one."""
        self._host, self._port = bare_host(host), port
        self._end = threading.Event()
        try:
            ipaddress.ip_address(self._host)
        except ValueError:
            threading.Thread(target=self._run, name="resolver", daemon=True).start()
        else:
            self.address = self._host

    def close(self) -> None:
        """End the thread once the question under way has an answer."""
        self._end.set()

    def _run(self) -> None:
        while not self._end.is_set():
            try:
                found = look_up(self._host, self._port, type=socket.SOCK_STREAM)
                self.address = self._best([str(answer[4][0]) for answer in found])
                self._notice("")
            except (OSError, UnicodeError) as error:  # UnicodeError: no name that a name server takes
                self._notice(printable(f"{self._host}: {error}", 200))
            self._end.wait(AGAIN_S)

    def _notice(self, problem: str) -> None:
        """Log a new problem once."""
        if problem and problem != self.problem:
            log.warning("no address: %s", problem)
        self.problem = problem

    def _best(self, found: list[str]) -> str | None:
        """The present address while it answers: no name server cuts a session. Else one of those found that does."""
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
