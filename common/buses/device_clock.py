"""Compares the clock of one serial device with the host's, separately for each connection."""

from collections.abc import Sequence

from common.buses.serial_device import SerialDevice
from common.timing.standstill import HostClock, Witness


class DeviceClock:
    """Detects standstills of the host with the reports of one serial line."""

    def __init__(self, line: SerialDevice, clock: HostClock | None) -> None:
        """Compare reports of `line` with `clock`; without `clock`, with a new `HostClock`."""
        self._line = line
        self._clock = HostClock() if clock is None else clock
        self._witness, self._times_lost = Witness(), 0

    def step(self, reported_us: Sequence[int]) -> float:
        """Return the duration for which the host's clock stood still before the last poll of the line, s; mostly 0.

        Args:
            reported_us: device time in each report of that poll, us modulo 2^32.
        """
        if self._line.times_lost != self._times_lost:  # a new connection: another device, or this one after a restart
            self._witness, self._times_lost = Witness(), self._line.times_lost
        if not reported_us:
            return 0.0
        return self._witness.report(self._clock.now_s(), reported_us, drained=self._line.drained)
