"""When a sensor took its readings: by the sensor's own clock, for the way from it is not regular."""

FOLLOWS = 0.05
"""Part of each reading's delay that the clock's own takes over."""
MOST_LATE_S = 0.005
"""A reading that a busy machine held up for longer counts as this late: it says nothing of the usual way, s."""
STEP_S = 0.001
"""The clock is set only when it is off by more than this: readings keep the distances that they were taken at, s."""
LOST_S = 1.0
"""A reading that arrives so much later or earlier than it should is timed by another clock: the sensor's began anew."""
_WRAPS = 1 << 32


class SensorClock:
    """Times of readings in the time of who receives them."""

    def __init__(self) -> None:
        """No reading came yet."""
        self._device_us = 0
        self._first_s: float | None = None
        self._delay_s = self._held_s = 0.0

    def step(self, arrived_s: float, device_us: int) -> float:
        """The time of a reading, s; how late readings usually are is part of it.

        Args:
            arrived_s: when it came, s.
            device_us: when it was taken by the sensor's clock, us modulo 2^32.
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
