"""An attacker without a trusted key, as a process of its own: `python attack.py KIND COUNT PORT SERVER_KEY`."""

import os
import socket
import struct
import sys
from collections.abc import Callable
from contextlib import suppress
from random import Random

import zmq

AT_ONCE = 100
THROWN_OUT = (
    zmq.EVENT_HANDSHAKE_FAILED_AUTH
    | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
    | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
    | zmq.EVENT_DISCONNECTED
)
PATIENCE_MS = 5000
"""A busy machine may let a stranger wait that long before it throws it out."""
GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x01CURVE".ljust(23, b"\0") + bytes(32)
"""What a ZMTP 3.1 client says first: signature, version, mechanism, role."""


def connect(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=5.0)


def garbage(port: int, rng: Random) -> None:
    """Random bytes, and gone."""
    with connect(port) as victim:
        victim.sendall(rng.randbytes(rng.randrange(1, 3000)))


def huge_frame(port: int, rng: Random) -> None:
    """A handshake command that announces exabytes, with a little of it."""
    with connect(port) as victim:
        victim.sendall(GREETING + b"\x06" + struct.pack(">Q", rng.randrange(1 << 40, 1 << 62)) + bytes(2000))


def broken_handshake(port: int, rng: Random) -> None:
    """A CurveZMQ HELLO whose contents are dice."""
    with connect(port) as victim:
        hello = b"\x05HELLO\x01\x00" + rng.randbytes(192)
        victim.sendall(GREETING + b"\x04" + bytes([len(hello)]) + hello)


class Slow:
    """Connections that say half of a greeting and then nothing, a hundred of them held open at a time."""

    def __init__(self) -> None:
        self._held: list[socket.socket] = []

    def __call__(self, port: int, rng: Random) -> None:
        victim = connect(port)
        victim.sendall(GREETING[: rng.randrange(1, 64)])
        self._held.append(victim)
        if len(self._held) > AT_ONCE:
            self._held.pop(0).close()


class Stranger:
    """ZeroMQ clients, each with a key that nobody trusts, or without any."""

    def __init__(self, server_key: bytes, has_key: bool) -> None:
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._server_key, self._has_key = server_key, has_key
        self._held: list[tuple[zmq.Socket[bytes], zmq.Socket[bytes]]] = []

    def __call__(self, port: int, rng: Random) -> None:
        client = self._context.socket(zmq.DEALER)
        client.setsockopt(zmq.LINGER, 0)
        if self._has_key:
            public, secret = zmq.curve_keypair()
            client.setsockopt(zmq.CURVE_SERVERKEY, self._server_key)
            client.setsockopt(zmq.CURVE_PUBLICKEY, public)
            client.setsockopt(zmq.CURVE_SECRETKEY, secret)
        fate = client.get_monitor_socket(THROWN_OUT)
        client.connect(f"tcp://127.0.0.1:{port}")
        with suppress(zmq.Again):  # thrown out already, it has no pipe left that could take a message
            client.send(b"let me in", zmq.NOBLOCK)
        self._held.append((client, fate))
        self.wait_until_thrown_out(all_but=16)

    def wait_until_thrown_out(self, all_but: int) -> None:
        """Each has had the victim's answer before it is closed: the victim has refused as many as knocked."""
        while len(self._held) > all_but:
            oldest, its_fate = self._held.pop(0)
            its_fate.poll(PATIENCE_MS)
            oldest.disable_monitor()
            oldest.close()


def main() -> None:
    kind, count, port, server_key = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4].encode()
    kinds: dict[str, Callable[[int, Random], None]] = {
        "garbage": garbage,
        "huge_frame": huge_frame,
        "broken_handshake": broken_handshake,
        "slow": Slow(),
        "wrong_key": Stranger(server_key, has_key=True),
        "no_key": Stranger(server_key, has_key=False),
    }
    attack, rng = kinds[kind], Random(count)
    for number in range(count):
        with suppress(OSError):  # being thrown out is the aim of the defence
            attack(port + number % 5, rng)
    if isinstance(attack, Stranger):
        attack.wait_until_thrown_out(all_but=0)
    print("done", flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
