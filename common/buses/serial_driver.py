"""Base of the drivers of serial devices that report at their own rate by their own clock."""

import math
from collections.abc import Sequence
from typing import ClassVar

from common.buses.serial_device import SerialDevice
from common.buses.serial_messages import DeviceKind
from common.buses.wiring import SYSTEM, Wiring
from common.timing.standstill import HostClock, Witness


class SerialDriver:
    """Reads one device, and detects standstills of the host by comparing the device's clock with the host's.

    Attributes:
        line: line to the device.
        measured_s: arrival time of the last report, s; -inf before the first.
        stood_still_s: duration of a standstill of the host's clock before the last `read`, s.
    """

    KIND: ClassVar[DeviceKind]
    BYTES_PER_S: ClassVar[int]
    """Data rate of the reports on the line, bytes/s."""

    def __init__(self, finger: str, address: str, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the device at `address` in the background; `clock` gives the times passed to `read`."""
        self.line = SerialDevice(address, self.KIND, finger, wiring)
        self.measured_s = -math.inf
        self.stood_still_s = 0.0
        self._clock = HostClock() if clock is None else clock
        self._witness, self._times_lost = Witness(), 0

    def _standstill_s(self, reported_us: Sequence[int]) -> float:
        """Return the duration for which the host's clock stood still before the last poll of the line, s; mostly 0.

        Args:
            reported_us: device time in each report of that poll, us modulo 2^32.
        """
        if self.line.times_lost != self._times_lost:  # a new connection: another device, or this one after a restart
            self._witness, self._times_lost = Witness(), self.line.times_lost
        if not reported_us:
            return 0.0
        return self._witness.report(self._clock.now_s(), reported_us, drained=self.line.drained)

    @property
    def unread_s(self) -> float:
        """Time that the device took to send the unread reports, s."""
        return self.line.unread_bytes() / self.BYTES_PER_S

    def _no_report(self, since_s: float) -> str:
        """Return why nothing was reported since a time, s; empty where there is a report."""
        if not self.line.connected:
            return "not connected"
        return "" if self.measured_s > since_s else "no report"
