"""The connection to a socketcand gateway: python-can's own, but it notices the gateway's end and never waits for it."""

import select
import socket

import can
from can.interfaces.socketcand import SocketCanDaemonBus

from common import device_socket

ANSWER_S = 1.0
"""A gateway that says nothing for this long is not there."""
_SOCKET = "_SocketCanDaemonBus__socket"
"""The library offers no way to its socket."""


class GatewayBus(SocketCanDaemonBus):
    """One connection to a gateway; once it is open, sending and receiving with no timeout do not block."""

    def __init__(self, channel: str, host: str, port: int) -> None:
        """Connect; blocks until the gateway has answered, a few seconds at most.

        Raises:
            can.CanError, OSError: the gateway is not there, or has no such channel.
        """
        _ask(host, port)
        try:
            super().__init__(channel, host, port, tcp_tune=True)
        except (can.CanError, OSError):
            if hasattr(self, _SOCKET):
                self._connection.close()
            raise
        device_socket.tune(self._connection)

    @property
    def _connection(self) -> socket.socket:
        connection: socket.socket = getattr(self, _SOCKET)
        return connection

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame.

        Raises:
            can.CanTimeoutError: the gateway takes nothing at the moment; the frame is not sent.
            OSError: the connection has ended.
        """
        # The library waits without end for a gateway that reads no more.
        if not select.select((), (self._connection,), (), timeout or 0.0)[1]:
            raise can.CanTimeoutError("the gateway takes nothing")
        super().send(msg)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        message, filtered = super()._recv_internal(timeout)
        if message is None and self._ended():
            raise can.CanOperationError("the gateway has hung up")
        return message, filtered

    def _expect_msg(self, msg: str) -> None:
        if not select.select((self._connection,), (), (), ANSWER_S)[0]:
            raise can.CanTimeoutError(f"the gateway does not answer with {msg!r}")
        super()._expect_msg(msg)

    def _ended(self) -> bool:
        # At the end of a connection the library reads an empty text, for ever.
        try:
            return self._connection.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b""
        except BlockingIOError:
            return False


def _ask(host: str, port: int) -> None:
    """Where nobody listens the library tries for 10 s without a pause, at a whole core's cost: so ask first."""
    with socket.create_connection((host, port), timeout=ANSWER_S) as connection:
        if not connection.recv(16).startswith(b"< hi"):
            raise can.CanInitializationError("what answers there is no socketcand gateway")
