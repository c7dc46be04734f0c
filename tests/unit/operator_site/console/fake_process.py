"""A process of the remote site with real Curve, which serves one reader what a test says."""

import time
from collections.abc import Callable

import zmq

from common.link.authenticator import Authenticator
from common.link.curve import prepare_socket, serve_curve
from common.link.keys import TrustedKeys, load_keys
from common.wire.streams import STREAMS
from tests.conftest import Keys

PATIENCE_S = 20.0
"""Longest wait for what must happen, s."""


class FakeProcess:
    """Binds the port of a stream."""

    def __init__(self, stream: str, base_port: int, keys: Keys) -> None:
        trusted = TrustedKeys(keys.remote)
        self._context = zmq.Context()
        self._authenticator = Authenticator(self._context, lambda _, key: trusted.role(key) is not None)
        self._socket: zmq.Socket[bytes] = self._context.socket(zmq.ROUTER)
        prepare_socket(self._socket)
        serve_curve(self._socket, load_keys(keys.remote), stream)
        self._socket.bind(f"tcp://127.0.0.1:{base_port + STREAMS[stream].port}")
        self._who = b""

    def send_raw(self, *parts: bytes) -> None:
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
