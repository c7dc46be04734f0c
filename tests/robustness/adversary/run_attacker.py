"""An attacker as a process of its own, over real sockets.

Run as `python -m tests.robustness.adversary.run_attacker WHAT KEYS PORTS`.
"""

import argparse
import os
import time
from contextlib import suppress
from pathlib import Path

import zmq

from common.link.curve import prepare_socket, use_curve
from common.link.keys import KeyPair, create_keys, load_keys
from common.runtime.scheduling import give_way
from common.wire.streams import STREAMS
from tests.robustness.adversary.attacker import Attacker, attack

STEP_S = 0.01
KINDS = {
    "motion": zmq.PUSH,
    "heartbeat": zmq.DEALER,
    "control": zmq.DEALER,
    "desk": zmq.DEALER,
    "touch": zmq.XSUB,
    "observed": zmq.XSUB,
    "feed": zmq.XSUB,
}
SUBSCRIBE = b"\x01"
LARGE_TOPIC = 6000
"""Bytes; a publisher keeps every topic of a connection."""


class CurveLine:
    """Sockets of one key to every port that it is given; what is sent waits in no queue of their own for long."""

    def __init__(self, keys: KeyPair, ports: dict[str, int], server_keys: dict[str, str], deaf: bool) -> None:
        """`deaf`: never read anything, whatever comes."""
        self._deaf = deaf
        self._sockets: dict[str, zmq.Socket[bytes]] = {}
        context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        for stream, port in ports.items():
            socket = context.socket(KINDS[stream])
            prepare_socket(socket)
            use_curve(socket, keys, server_keys.get(stream, server_keys["remote"]))
            socket.connect(f"tcp://127.0.0.1:{port}")
            if KINDS[stream] == zmq.XSUB:
                socket.send(SUBSCRIBE)
            self._sockets[stream] = socket

    def send(self, stream: str, packet: bytes) -> None:
        """Send, and to the operator's desk what is sent to `control`; what finds no room is dropped."""
        for name in (stream, "desk") if stream == "control" else (stream,):
            self._send(name, packet)

    def subscribe(self, packet: bytes) -> None:
        """Subscribe to something at every publisher."""
        for stream, kind in KINDS.items():
            if kind == zmq.XSUB:
                self._send(stream, SUBSCRIBE + packet)

    def _send(self, stream: str, packet: bytes) -> None:
        socket = self._sockets.get(stream)
        if socket is not None:
            with suppress(zmq.Again):
                socket.send(packet, zmq.DONTWAIT)

    def receive(self, stream: str) -> list[bytes]:
        """Everything unread of a stream, unless deaf."""
        found: list[bytes] = []
        socket = self._sockets.get(stream)
        while socket is not None and not self._deaf and len(found) < 1000 and socket.poll(0):
            found.append(socket.recv())
        return found


def main() -> None:
    """Attack until the time is over or the process is ended."""
    parser = argparse.ArgumentParser()
    parser.add_argument("what")
    parser.add_argument("keys", type=Path)
    parser.add_argument("base_port", type=int)
    parser.add_argument("remote_key")
    parser.add_argument("--desk", type=int, default=0)
    parser.add_argument("--feed", type=int, default=0)
    parser.add_argument("--operator-key", default="")
    parser.add_argument(
        "--no-motion",
        action="store_true",
        help="a copy of the operator's key that neither latches nor works at the desk",
    )
    parser.add_argument("--deaf", action="store_true", help="never read what comes")
    parser.add_argument("--subscriptions", action="store_true", help="subscribe to large topics, too")
    parser.add_argument("--seconds", type=float, default=3600.0)
    given = parser.parse_args()
    give_way(10)  # attackers sit at other machines: their work must not take the processors from the sites
    if not given.keys.exists():
        create_keys(given.keys)
    ports = {stream.name: given.base_port + stream.port for stream in STREAMS.values()}
    ports |= {name: port for name, port in (("desk", given.desk), ("feed", given.feed)) if port}
    if given.no_motion:
        ports.pop("motion")
        ports.pop("desk", None)
    server_keys = {"remote": given.remote_key, "desk": given.operator_key, "feed": given.operator_key}
    line = CurveLine(load_keys(given.keys), ports, server_keys, given.deaf)
    attacker = Attacker(line, time.monotonic_ns)
    end_s = time.monotonic() + given.seconds
    for count, _ in enumerate(attack(attacker, given.what)):
        if given.what == "small":
            line.subscribe(str(count).encode())
        if given.subscriptions:
            line.subscribe(str(count).encode().ljust(LARGE_TOPIC, b"x"))
        if time.monotonic() > end_s:
            break
        time.sleep(STEP_S)
    os._exit(0)


if __name__ == "__main__":
    main()
