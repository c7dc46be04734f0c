"""Notifies the supervisor of a service with the sd_notify protocol: datagrams of `NAME=VALUE` lines to a socket."""

import contextlib
import logging
import os
import socket

log = logging.getLogger(__name__)


class Supervisor:
    """The supervisor that started this process as a service; none when the environment names none."""

    def __init__(self, address: str | None = None) -> None:
        """Use the supervisor's address: a path, or `@NAME` in the abstract namespace; by default $NOTIFY_SOCKET."""
        named = os.environ.get("NOTIFY_SOCKET", "") if address is None else address
        self._address = f"\0{named[1:]}" if named.startswith("@") else named
        self._socket: socket.socket | None = None
        if named.startswith(("/", "@")):
            # A supervisor that does not read must not block the loop.
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC | socket.SOCK_NONBLOCK)
        elif named:
            log.warning("NOTIFY_SOCKET %s is no local socket: the supervisor gets no notifications", named)

    def ready(self) -> None:
        """Report that the devices are connected and the loop runs."""
        self._say("READY=1")

    def alive(self, status: str) -> None:
        """Report that the loop still runs; `status` is text for people."""
        self._say("WATCHDOG=1", f"STATUS={' '.join(status.split())}")

    def stopping(self) -> None:
        """Report that the loop has ended, intentionally or by a failure."""
        self._say("STOPPING=1")

    def close(self) -> None:
        """Close the socket; later reports are dropped."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def __enter__(self) -> "Supervisor":
        return self

    def __exit__(self, *_: object) -> None:
        self.stopping()
        self.close()

    def _say(self, *lines: str) -> None:
        if self._socket is None:
            return
        # A supervisor that is gone or busy gets the next one; its own watchdog detects a lack of them.
        with contextlib.suppress(OSError):
            self._socket.sendto("\n".join(lines).encode(), self._address)
