"""Bare baselines of the link: CurveZMQ sockets and a TCP socket, without any layer above them."""

import socket
import struct

import zmq

from common.link.curve import use_curve
from common.link.keys import KeyPair

_NUMBER = struct.Struct("<q")
_LENGTH = struct.Struct(">I")


def numbered(body: bytes, sequence: int) -> bytes:
    """A message as long as `body` (at least 8 bytes) that carries a number."""
    return _NUMBER.pack(sequence) + body[_NUMBER.size :]


def read_number(message: bytes) -> int:
    """The number that a message carries."""
    return int(_NUMBER.unpack_from(message)[0])


class BareCurve:
    """One side of a CurveZMQ pair of sockets that keep only the newest message; any client may connect."""

    def __init__(self, address: str, kind: int, keys: KeyPair, server_public_key: str | None = None):
        """Serve at `address`, or connect to the server that has this key."""
        self._context = zmq.Context()
        self._socket: zmq.Socket[bytes] = self._context.socket(kind)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.CONFLATE, 1)
        if kind == zmq.SUB:
            self._socket.setsockopt(zmq.SUBSCRIBE, b"")
        if server_public_key is None:
            self._socket.setsockopt(zmq.CURVE_SERVER, 1)
            self._socket.setsockopt(zmq.CURVE_SECRETKEY, keys.secret)
            self._socket.setsockopt(zmq.CURVE_PUBLICKEY, keys.public.encode())
            self._socket.bind(address)
        else:
            use_curve(self._socket, keys, server_public_key)
            self._socket.connect(address)

    def send(self, message: bytes) -> None:
        """Send a message, or drop it when nobody is connected."""
        try:
            self._socket.send(message, zmq.DONTWAIT)
        except zmq.Again:
            return

    def receive_now(self) -> bytes | None:
        """The newest unread message."""
        try:
            return self._socket.recv(zmq.DONTWAIT)
        except zmq.Again:
            return None

    def receive(self, seconds: float) -> bytes | None:
        """The next message within `seconds`."""
        self._socket.setsockopt(zmq.RCVTIMEO, round(seconds * 1e3))
        try:
            return self._socket.recv()
        except zmq.Again:
            return None

    def close(self) -> None:
        """Close the socket, and drop unsent messages."""
        self._context.destroy(linger=0)


class PlainTcp:
    """One side of a TCP connection with length-prefixed messages, each sent at once (TCP_NODELAY)."""

    def __init__(self, connection: socket.socket):
        self._connection = connection
        self._connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._unread = b""

    @classmethod
    def serve(cls, host: str, port: int) -> "PlainTcp":
        """Wait for the other side to connect."""
        with socket.create_server((host, port)) as listener:
            listener.settimeout(30.0)
            connection, _ = listener.accept()
        return cls(connection)

    @classmethod
    def connect(cls, host: str, port: int) -> "PlainTcp":
        """Connect to a side that already serves."""
        return cls(socket.create_connection((host, port), timeout=30.0))

    def send(self, message: bytes) -> None:
        """Send one message."""
        self._connection.sendall(_LENGTH.pack(len(message)) + message)

    def receive(self, seconds: float) -> bytes | None:
        """The next message within `seconds`."""
        self._connection.settimeout(seconds)
        while True:
            if len(self._unread) >= _LENGTH.size:
                end = _LENGTH.size + _LENGTH.unpack_from(self._unread)[0]
                if len(self._unread) >= end:
                    message, self._unread = self._unread[_LENGTH.size : end], self._unread[end:]
                    return message
            try:
                part = self._connection.recv(65536)
            except TimeoutError:
                return None
            if not part:
                return None
            self._unread += part

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()
