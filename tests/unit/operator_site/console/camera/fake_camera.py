"""The camera's process with real Curve, which sends what a test says."""

import time

from common.wire.camera_messages import CameraAsk, PictureHeader
from tests.conftest import Keys
from tests.unit.operator_site.console.camera.made_pictures import CONTENT, header
from tests.unit.operator_site.console.fake_process import FakeProcess, until

__all__ = ["FakeCamera", "until"]


class FakeCamera(FakeProcess):
    """Binds the port of the stream `camera`, and reads the packets of one reader."""

    def __init__(self, base_port: int, keys: Keys) -> None:
        super().__init__("camera", base_port, keys)
        self.asks: list[CameraAsk] = []
        self._heard_ns = 0

    def hear(self) -> None:
        """Read the waiting packets."""
        while self._socket.poll(0):
            self._who, packed = self._socket.recv_multipart()
            self._heard_ns = time.monotonic_ns()
            self.asks.append(CameraAsk.decode(packed))

    def send(self, sequence: int, content: bytes = CONTENT, **changed: object) -> None:
        """Send a picture that is captured now to the reader, which has asked."""
        self.send_raw(self.header(sequence, **changed).encode(), content)

    def header(self, sequence: int, **changed: object) -> PictureHeader:
        """The header of a picture that is captured now."""
        times = {"asked_ns": self.asks[-1].time_ns, "heard_ns": self._heard_ns}
        return header(sequence, time.monotonic_ns(), **(times | changed))
