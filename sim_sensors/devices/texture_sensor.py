"""Emulate the texture sensor's module, which sends the converter's samples in chunks of ten."""

import math

import numpy as np
from numpy.typing import NDArray

from common.buses.serial_messages import BadPayload, DeviceKind, Frame, Identity, MessageId, TextureSamples
from sim_sensors.devices.serial_module import SerialModule

RATE_HZ = 2000
CHUNK = 10
VOLTS = 10.0
_SAMPLE_US = 1_000_000 // RATE_HZ
_LONGEST = 100 * CHUNK


class TextureSensor(SerialModule):
    """Emulated module of one remote finger's piezo sensor.

    The chunk's time is that of its first sample on the sensor's own sample clock.
    """

    def __init__(self, finger: int, powered_s: float = 0.0) -> None:
        identity = Identity(DeviceKind.TEXTURE_SENSOR, finger, f"TX{finger:04d}", 1, RATE_HZ, -VOLTS, VOLTS)
        super().__init__(identity, powered_s)
        self._counts = b""
        self._sent = 0

    def add_samples(self, counts: NDArray[np.int16]) -> None:
        """Add the converter's samples since the last call, oldest first, -2048..2047."""
        self.due_s = -math.inf
        self._counts += counts.astype("<i2", copy=False).tobytes()
        if len(self._counts) > 2 * _LONGEST:
            lost = len(self._counts) - 2 * _LONGEST
            self._counts = self._counts[lost:]
            self._sent += lost // 2

    def _obey(self, frame: Frame, now_s: float) -> None:
        raise BadPayload(f"texture sensor: no command {frame.message_id:#04x}")

    def _run(self, now_s: float) -> None:
        while len(self._counts) >= 2 * CHUNK:
            chunk, self._counts = self._counts[: 2 * CHUNK], self._counts[2 * CHUNK :]
            head = TextureSamples.HEAD.pack(self._sent * _SAMPLE_US & 0xFFFFFFFF, CHUNK)
            self._say(MessageId.TEXTURE_SAMPLES, head + chunk)
            self._sent += CHUNK

    def _next_s(self) -> float:
        return math.inf  # until new samples come
