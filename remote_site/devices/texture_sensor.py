"""Driver of one finger's piezo texture sensor: 2 kHz, 12 bit, 10 V for 10 N."""

import struct
from collections import deque

from common.buses.serial_driver import SerialDriver
from common.buses.serial_messages import DeviceKind, TextureSamples
from common.buses.wiring import SYSTEM, Wiring
from common.limits import GAP_S
from common.timing.standstill import HostClock

VOLTS_PER_COUNT = 10.0 / 2048.0
_MOST_AT_ONCE = 4
"""Maximum number of chunks in one tick; a late site catches up in several short ticks."""
_MOST_WAITING = 40
"""Maximum number of chunks kept while the loop stands still: 0.2 s of signal; older ones are dropped."""


class TextureSensor(SerialDriver):
    """Returns the signal in the sensor's own chunks, oldest first."""

    KIND = DeviceKind.TEXTURE_SENSOR
    BYTES_PER_S = 200 * 31

    def __init__(self, finger: str, address: str, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the sensor at `address` in the background; `clock` gives the times passed to `read`."""
        super().__init__(finger, address, clock, wiring)
        self.waiting: deque[bytes] = deque(maxlen=_MOST_WAITING)
        """Chunks that were read and not yet returned."""

    def read(self, t_s: float) -> bytes | None:
        """Return the next chunks of counts (int16 little endian), oldest first; None if none waits at `t_s`, s.

        One call returns at most _MOST_AT_ONCE chunks.
        After a standstill of the host's clock, older chunks are dropped.
        """
        chunks = self.line.poll(TextureSamples)
        if chunks:
            self.waiting.extend([samples.counts for samples in chunks])
            self.measured_s = t_s
        self.stood_still_s = self._standstill_s([samples.device_time_us for samples in chunks])
        if self.stood_still_s > 0.0:
            self.waiting.clear()
        if t_s - self.measured_s > GAP_S:
            self.waiting.clear()  # the sensor is silent: its last chunks are too old
        waiting = self.waiting
        if len(waiting) <= 1:
            return waiting.popleft() if waiting else None
        return b"".join([waiting.popleft() for _ in range(min(len(waiting), _MOST_AT_ONCE))])


def texture_v(counts: bytes) -> list[float]:
    """Convert one chunk of counts to the signal, -10..10 V."""
    return [count * VOLTS_PER_COUNT for count in struct.unpack(f"<{len(counts) // 2}h", counts)]
