"""The camera's process with real Curve, which sends what a test says."""

import time
from collections.abc import Callable

import zmq

from common.link.authenticator import Authenticator
from common.link.curve import prepare_socket, serve_curve
from common.link.keys import TrustedKeys, load_keys
from common.wire.camera_messages import CameraAsk, PictureHeader
from common.wire.streams import STREAMS
from tests.conftest import Keys
from tests.unit.operator_site.console.camera.made_pictures import CONTENT, header

PATIENCE_S = 20.0
"""Longest wait for what must happen, s."""


class FakeCamera:
    """Binds the port of the stream `camera`, and reads the packets of one reader."""

    def __init__(self, base_port: int, keys: Keys) -> None:
        trusted = TrustedKeys(keys.remote)
        self._context = zmq.Context()
        self._authenticator = Authenticator(self._context, lambda _, key: trusted.role(key) is not None)
        self._socket: zmq.Socket[bytes] = self._context.socket(zmq.ROUTER)
        prepare_socket(self._socket)
        serve_curve(self._socket, load_keys(keys.remote), "camera")
        self._socket.bind(f"tcp://127.0.0.1:{base_port + STREAMS['camera'].port}")
        self.asks: list[CameraAsk] = []
        self._who, self._heard_ns = b"", 0

    def hear(self) -> None:
        """Read the waiting packets."""
        while self._socket.poll(0):
            self._who, packed = self._socket.recv_multipart()
            self._heard_ns = time.monotonic_ns()
            self.asks.append(CameraAsk.decode(packed))

    def send(self, sequence: int, content: bytes = CONTENT, **changed: object) -> None:
        """Send a picture that is captured now to the reader, which has asked."""
        self.send_raw([self.header(sequence, **changed).encode(), content])

    def header(self, sequence: int, **changed: object) -> PictureHeader:
        """The header of a picture that is captured now."""
        times = {"asked_ns": self.asks[-1].time_ns, "heard_ns": self._heard_ns}
        return header(sequence, time.monotonic_ns(), **(times | changed))

    def send_raw(self, parts: list[bytes]) -> None:
        """Send a message to the reader, which has asked."""
        self._socket.send_multipart([self._who, *parts])

    def close(self) -> None:
        """End the process."""
        self._authenticator.close()
        self._context.destroy(linger=0)


def until(reached: Callable[[], object]) -> None:
    """Call this again until it is true, every 2 ms as the console's loop does."""
    end_s = time.monotonic() + PATIENCE_S
    while not reached():
        if time.monotonic() > end_s:
            raise AssertionError("it was not reached")
        time.sleep(0.002)
