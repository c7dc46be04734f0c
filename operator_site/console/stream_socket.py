"""Connects with a process of the remote site that serves a stream beside the session; never blocks."""

import contextlib

import zmq
import zmq.utils.monitor

from common.link.curve import Inbox, prepare_socket, use_curve
from common.link.host_name import Resolver, is_ipv6, tcp_endpoint
from common.link.keys import KeyPair
from common.wire.packets import MAX_PACKET
from common.wire.streams import STREAMS

RECONNECT_S = 3.0
"""Silence after which a line connects again, s."""
_WAITING = 8
"""Maximum number of packets that wait to be sent."""
_FINAL = 400
"""Status of a handshake whose key is not trusted; the library does not try again."""


class StreamSocket:
    """A reader's end of a stream, connected in the background; an absent process is no error."""

    def __init__(
        self,
        stream: str,
        host: str,
        base_port: int,
        keys: KeyPair,
        remote_public_key: str,
        most_bytes: int = MAX_PACKET,
    ):
        """Connect to the remote site's host.

        Args:
            base_port: first port of the remote site's link.
            most_bytes: size of the largest part of a received message, bytes.
        """
        self.refused = False
        """Whether the process has refused this side's key since the last connection."""
        self._keys, self._remote_key = keys, remote_public_key
        self._most_bytes, self._port = most_bytes, base_port + STREAMS[stream].port
        self._resolver = Resolver(host, self._port)
        self._context = zmq.Context()
        self._socket: zmq.Socket[bytes] | None = None
        self._monitor: zmq.Socket[bytes] | None = None
        self._open()

    def _open(self) -> None:
        socket = self._socket = self._context.socket(zmq.DEALER)
        prepare_socket(socket, self._most_bytes)
        socket.setsockopt(zmq.SNDHWM, _WAITING)
        # A packet to an absent process must fail now: later, its times would be wrong.
        socket.setsockopt(zmq.IMMEDIATE, 1)
        use_curve(socket, self._keys, self._remote_key)
        self._monitor = socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_HANDSHAKE_SUCCEEDED)
        self._address = self._resolver.address
        if self._address is not None:
            socket.setsockopt(zmq.IPV6, is_ipv6(self._address))
            socket.connect(tcp_endpoint(self._address, self._port))
        self._inbox = Inbox(socket)

    def _disconnect(self) -> None:
        if self._socket is not None:
            self._socket.disable_monitor()
            self._socket.close(linger=0)
        if self._monitor is not None:
            self._monitor.close()
        self._socket = self._monitor = None

    def reconnect(self) -> None:
        """Connect again: the library gives up after a refusal and after bytes that are no packet."""
        self._disconnect()
        try:
            self._open()
        except zmq.ZMQError:  # such as without a free file descriptor; another attempt follows
            self._disconnect()

    def receive(self) -> list[bytes]:
        """Return the parts of the next message; empty if none waits."""
        if self._address != self._resolver.address:  # the name server has answered
            self.reconnect()
        if self._socket is None or self._monitor is None:
            return []
        while self._monitor.poll(0):
            event = zmq.utils.monitor.recv_monitor_message(self._monitor)
            refused = event["event"] == zmq.EVENT_HANDSHAKE_FAILED_AUTH and event["value"] == _FINAL
            self.refused = refused or (self.refused and event["event"] != zmq.EVENT_HANDSHAKE_SUCCEEDED)
        return [frame.bytes for frame in self._inbox.take()]

    def send(self, packet: bytes) -> None:
        """Send a packet; it is dropped where no process is connected."""
        if self._socket is not None:
            with contextlib.suppress(zmq.Again):
                self._socket.send(packet, zmq.DONTWAIT)
            self._inbox.stale()

    def close(self) -> None:
        """Disconnect."""
        self._resolver.close()
        self._disconnect()
        self._context.destroy(linger=0)


class Reconnection:
    """Connects a silent line again. Pure: times are arguments, ns."""

    def __init__(self, line: StreamSocket, now_ns: int):
        self._line, self._connected_ns = line, now_ns

    def step(self, now_ns: int, silent_s: float) -> None:
        """Connect again if nothing came for RECONNECT_S, s, and the last attempt is as old."""
        if silent_s > RECONNECT_S and now_ns - self._connected_ns > RECONNECT_S * 1e9:
            self._connected_ns = now_ns
            self._line.reconnect()
