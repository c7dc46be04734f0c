"""Times readings by the sensor's own clock, because their transport delay varies."""

FOLLOWS = 0.05
"""Fraction of each reading's change of delay that corrects the estimated delay."""
MOST_LATE_S = 0.005
"""Limit of the change of delay that one reading contributes, s; a busy machine holds readings up for longer."""
STEP_S = 0.001
"""Minimum error of the applied delay before it is corrected, s; in between, readings keep the sensor's intervals."""
LOST_S = 1.0
"""Maximum change of delay, s; a larger one means that the sensor's clock has restarted."""
_WRAPS = 1 << 32


class SensorClock:
    """Converts the sensor's times of readings to the receiver's time."""

    def __init__(self) -> None:
        """Begin without a reading."""
        self._device_us = 0
        self._first_s: float | None = None
        self._delay_s = self._held_s = 0.0

    def step(self, arrived_s: float, device_us: int) -> float:
        """Return the time of a reading, s; it includes the usual transport delay.

        Args:
            arrived_s: time of arrival, s.
            device_us: time of the reading by the sensor's clock, us modulo 2^32.
        """
        if self._first_s is not None:
            since_us = (device_us - self._device_us + _WRAPS // 2) % _WRAPS - _WRAPS // 2
            on_time_s = self._first_s + since_us * 1e-6
            late_s = arrived_s - on_time_s - self._delay_s
            if abs(late_s) <= LOST_S:
                self._delay_s += FOLLOWS * max(-MOST_LATE_S, min(MOST_LATE_S, late_s))
                if abs(self._delay_s - self._held_s) > STEP_S:
                    self._held_s = self._delay_s
                self._device_us, self._first_s = device_us, on_time_s
                return on_time_s + self._held_s
        self._device_us, self._first_s = device_us, arrived_s
        self._delay_s = self._held_s = 0.0
        return arrived_s
