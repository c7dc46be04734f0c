"""Measures a bare CurveZMQ ping between two processes, for comparison with the link's latency in the same run."""

import multiprocessing
import signal
import time
from multiprocessing.connection import Connection
from types import TracebackType

import zmq

from common.wire.messages import TOUCH_FIELDS
from common.wire.packets import N
from teletaction.session.processes import die_with_parent

PACKET_BYTES = 4 * N * len(TOUCH_FIELDS) + 16
"""Size of a ping, bytes: about that of a touch packet without events."""
_HOST = "127.0.0.1"
_SERVER_PUBLIC, _SERVER_SECRET = zmq.curve_keypair()


def _echo(parent: Connection) -> None:
    die_with_parent()
    # The fork inherits the launcher's handler, which would keep this process alive.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    context = zmq.Context()
    socket = context.socket(zmq.DEALER)
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.CURVE_SERVER, 1)
    socket.setsockopt(zmq.CURVE_SECRETKEY, _SERVER_SECRET)
    parent.send(socket.bind_to_random_port(f"tcp://{_HOST}"))
    while (packet := socket.recv()) != b"":
        socket.send(packet)
    context.destroy(linger=0)


class BarePing:
    """Measures round trips of one packet to an echoing process."""

    def __init__(self) -> None:
        """Start the echoing process and connect to it."""
        parent, child = multiprocessing.Pipe()
        self._process = multiprocessing.get_context("fork").Process(target=_echo, args=(child,), daemon=True)
        self._process.start()
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.DEALER)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.RCVTIMEO, 2000)
        public, secret = zmq.curve_keypair()
        self._socket.setsockopt(zmq.CURVE_SERVERKEY, _SERVER_PUBLIC)
        self._socket.setsockopt(zmq.CURVE_PUBLICKEY, public)
        self._socket.setsockopt(zmq.CURVE_SECRETKEY, secret)
        self._socket.connect(f"tcp://{_HOST}:{parent.recv()}")
        self.round_trips_s: list[float] = []

    def once(self) -> None:
        """Measure one round trip. A round trip without an answer within 2 s counts as 2 s."""
        packet = len(self.round_trips_s).to_bytes(PACKET_BYTES, "little")
        start_s = time.monotonic()
        self._socket.send(packet)
        try:
            while self._socket.recv() != packet:
                pass  # the late answer to an earlier packet
        except zmq.Again:
            self.round_trips_s.append(2.0)
            return
        self.round_trips_s.append(time.monotonic() - start_s)

    def __enter__(self) -> "BarePing":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.send(b"")
        self._process.join(1.0)
        if self._process.is_alive():
            self._process.kill()
        self._context.destroy(linger=200)
