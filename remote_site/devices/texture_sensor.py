"""Driver of one finger's piezo texture sensor: 2 kHz, 12 bit, 10 V for 10 N."""

import math
import struct
from collections import deque

from common.buses.device_clock import DeviceClock
from common.buses.serial_device import SerialDevice
from common.buses.serial_messages import DeviceKind, TextureSamples
from common.buses.wiring import SYSTEM, Wiring
from common.limits import GAP_S
from common.timing.standstill import HostClock

VOLTS_PER_COUNT = 10.0 / 2048.0
_BYTES_PER_S = 200 * 31
"""Data rate of a sensor's samples on its serial line, bytes/s."""
_MOST_AT_ONCE = 4
"""Maximum number of chunks in one tick; a late site catches up in several short ticks."""
_MOST_WAITING = 40
"""Maximum number of chunks kept while the loop stands still: 0.2 s of signal; older ones are dropped."""


class TextureSensor:
    """Returns the signal in the sensor's own chunks, oldest first."""

    def __init__(self, finger: str, address: str, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the sensor at `address` in the background; `clock` gives the times passed to `read`."""
        self.line = SerialDevice(address, DeviceKind.TEXTURE_SENSOR, finger, wiring)
        self.measured_s = -math.inf
        """Time of arrival of the last samples, s; -inf before the first."""
        self.stood_still_s = 0.0
        """Standstill of the host's clock before the last `read`, s, measured by the sensor's own clock."""
        self._witness = DeviceClock(self.line, clock)
        self.waiting: deque[bytes] = deque(maxlen=_MOST_WAITING)
        """Chunks that were read and not yet returned."""

    def read(self, t_s: float) -> bytes | None:
        """Return the next chunks of counts (int16 little endian), oldest first; None if none waits.

        One call returns at most _MOST_AT_ONCE chunks.

        After a standstill of the host's clock, older chunks are dropped.

        Args:
            t_s: time now, s.
        """
        if self.line.silent and not self.waiting:
            self.stood_still_s = 0.0
            return None
        chunks = self.line.poll(TextureSamples)
        if chunks:
            self.waiting.extend([samples.counts for samples in chunks])
            self.measured_s = t_s
        self.stood_still_s = self._witness.step([samples.device_time_us for samples in chunks])
        if self.stood_still_s > 0.0:
            self.waiting.clear()
        if t_s - self.measured_s > GAP_S:
            self.waiting.clear()  # the sensor is silent: its last chunks are too old
        waiting = self.waiting
        if len(waiting) <= 1:
            return waiting.popleft() if waiting else None
        return b"".join([waiting.popleft() for _ in range(min(len(waiting), _MOST_AT_ONCE))])

    @property
    def unread_s(self) -> float:
        """Duration of the samples that wait to be read, s."""
        return self.line.unread_bytes() / _BYTES_PER_S


def texture_v(counts: bytes) -> list[float]:
    """Convert one chunk of counts to the signal, -10..10 V."""
    return [count * VOLTS_PER_COUNT for count in struct.unpack(f"<{len(counts) // 2}h", counts)]
