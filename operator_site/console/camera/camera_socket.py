"""Connects with the camera's process at the remote site; never blocks."""

import contextlib

import zmq
import zmq.utils.monitor

from common.link.curve import Inbox, prepare_socket, use_curve
from common.link.host_name import Resolver, is_ipv6, tcp_endpoint
from common.link.keys import KeyPair
from common.wire.camera_messages import MAX_PICTURE
from common.wire.streams import STREAMS

_WAITING = 8
"""Maximum number of packets that wait to be sent."""
_FINAL = 400
"""Status of a handshake whose key is not trusted; the library does not try again."""


class CameraSocket:
    """A reader's end of the stream `camera`, connected in the background; an absent camera is no error."""

    def __init__(self, host: str, base_port: int, keys: KeyPair, remote_public_key: str):
        """Connect to the remote site's host.

        Args:
            host: name or address of the remote site.
            base_port: first port of the remote site's link.
            keys: keys of the operator site.
            remote_public_key: public key of the remote site.
        """
        self.refused = False
        """Whether the camera's process has refused this side's key since the last connection."""
        self._keys, self._remote_key = keys, remote_public_key
        self._port = base_port + STREAMS["camera"].port
        self._resolver = Resolver(host, self._port)
        self._context = zmq.Context()
        self._open()

    def _open(self) -> None:
        socket = self._context.socket(zmq.DEALER)
        prepare_socket(socket, MAX_PICTURE)
        socket.setsockopt(zmq.SNDHWM, _WAITING)
        # A packet to an absent camera must fail now: later, its times would be wrong.
        socket.setsockopt(zmq.IMMEDIATE, 1)
        use_curve(socket, self._keys, self._remote_key)
        self._monitor = socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_HANDSHAKE_SUCCEEDED)
        self._address = self._resolver.address
        if self._address is not None:
            socket.setsockopt(zmq.IPV6, is_ipv6(self._address))
            socket.connect(tcp_endpoint(self._address, self._port))
        self._socket, self._inbox = socket, Inbox(socket)

    def reconnect(self) -> None:
        """Connect again: the library gives up after a refusal and after bytes that are no packet."""
        self._socket.disable_monitor()
        self._monitor.close()
        self._socket.close(linger=0)
        self._open()

    def receive(self) -> list[bytes]:
        """Return the parts of the next message; empty if none waits."""
        if self._address != self._resolver.address:  # the name server has answered
            self.reconnect()
        while self._monitor.poll(0):
            event = zmq.utils.monitor.recv_monitor_message(self._monitor)
            refused = event["event"] == zmq.EVENT_HANDSHAKE_FAILED_AUTH and event["value"] == _FINAL
            self.refused = refused or (self.refused and event["event"] != zmq.EVENT_HANDSHAKE_SUCCEEDED)
        return [frame.bytes for frame in self._inbox.take()]

    def send(self, packet: bytes) -> None:
        """Send a packet; it is dropped where no camera is connected."""
        with contextlib.suppress(zmq.Again):
            self._socket.send(packet, zmq.DONTWAIT)
        self._inbox.stale()

    def close(self) -> None:
        """Disconnect."""
        self._resolver.close()
        self._socket.disable_monitor()
        self._monitor.close()
        self._context.destroy(linger=0)
