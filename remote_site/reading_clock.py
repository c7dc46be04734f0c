"""When a sensor took its readings, from when they arrived: the sensor is regular, the way from it is not."""

READING_S = 0.01
"""Period of the thermal sensor's readings, s."""
FOLLOWS = 0.05
"""Part of each reading's delay that the clock's own takes over."""
STEP_S = 0.001
"""The clock is set only when it is off by more than this: most readings lie exactly a period apart, s."""
LOST_S = 0.15
"""A reading that arrives so much later or earlier than it should begins a new count, s."""


class ReadingClock:
    """Times of readings, whole periods apart, in the time of who receives them."""

    def __init__(self) -> None:
        """No reading came yet."""
        self._number = 0
        self._first_s: float | None = None
        self._delay_s = self._held_s = 0.0

    def step(self, arrived_s: float, number: int) -> float:
        """The time of reading `number` that arrived at `arrived_s`, s; how late readings usually are is part of it."""
        if self._first_s is not None:
            on_time_s = self._first_s + (number - self._number) * READING_S
            late_s = arrived_s - on_time_s
            if abs(late_s - self._held_s) <= LOST_S:
                self._delay_s += FOLLOWS * (late_s - self._delay_s)
                if abs(self._delay_s - self._held_s) > STEP_S:
                    self._held_s = self._delay_s
                return on_time_s + self._held_s
        self._number, self._first_s = number, arrived_s
        self._delay_s = self._held_s = 0.0
        return arrived_s
