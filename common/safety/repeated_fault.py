"""Keeps a plate off after repeated faults, until a small test pulse moves it as it moves a sound plate.

After the first fault of a plate, clearing by a person is enough. After a further one within REPEATED_S the plate gets
only the drive of a test. The test has two rounds: one without drive, which measures drift, and one that cools and heats
by the same small amount. The reading's second difference over a round excludes steady drift. It is zero for a stuck
reading or a dead heater, and has the wrong sign for a reversed drive. A failed test is repeated after TEST_EVERY_S at
the earliest.
"""

import math
from operator import truediv

REPEATED_S = 600.0
"""Maximum time between two faults of a plate, s, after which it needs a test."""
TEST_EVERY_S = 30.0
"""Time from the start of one test pulse to the next, s."""
PULSE_S = 0.5
"""Duration of the cooling, and then of the heating, of a test pulse, s."""
WINDOW_S = 0.2
"""Averaging time of the reading at the start, in the middle and at the end of a round, s."""
SPACING_S = PULSE_S + 0.2
"""Time from one average to the next, s: the reading lags the drive by 0.1 s to 0.2 s."""
ROUND_S = 2.0 * SPACING_S + WINDOW_S
"""Duration of a round, s."""
CALM_SHARE = 0.5
"""Maximum second difference of the reading without drive, as a share of the value that passes the test."""


class RepeatedFault:
    """Faults and tests of one plate. Pure: times and readings in, drive out."""

    def __init__(self, drive: float, least_k: float) -> None:
        """Start without an earlier fault.

        Args:
            drive: drive of the test pulse, 0..1 of full drive.
            least_k: second difference of the reading that a sound plate exceeds in a test, K.
        """
        self.needs_test = False
        """Whether the plate gets only the drive of a test."""
        self._drive = drive
        self._least_k = least_k
        self._named_s: float | None = None
        self._next_s = -math.inf
        self._began_s: float
        self._calm: bool
        self._sums: list[float] = []
        self._counts: list[int] = []
        """Number of readings in each average of the round."""
        self.interrupt()

    def named(self, t_s: float) -> bool:
        """Take a fault of this plate at a time, s; return whether the plate needs a test now."""
        # After a clock was set back, or without a valid time, the earlier fault counts as recent.
        if self._named_s is not None and not t_s - self._named_s > REPEATED_S:
            self.demand_test()
        self._named_s = t_s
        return self.needs_test

    def demand_test(self) -> None:
        """Allow no drive before a test, even without an earlier fault."""
        self.needs_test = True
        self.interrupt()

    def step(self, t_s: float, plate_c: float, free: bool) -> float:
        """Return the present drive of the test, -1..1; a passed test ends `needs_test`.

        Call `interrupt` after a pause of 0.1 s or more between two steps.

        Args:
            t_s: time, s.
            plate_c: reading of the plate, C; NaN without a reading.
            free: whether the plate may be driven.
        """
        if not free or math.isnan(plate_c):
            self.interrupt()
            return 0.0
        at_s = t_s - self._began_s
        if at_s >= ROUND_S:
            self._judge()
        if not 0.0 <= at_s < ROUND_S:
            self._began_s, at_s = t_s, 0.0
            self._sums, self._counts = [0.0, 0.0, 0.0], [0, 0, 0]
            self._calm = self._calm and t_s >= self._next_s
            if self._calm:
                self._next_s = t_s + TEST_EVERY_S
        window = int(at_s / SPACING_S)
        if at_s - window * SPACING_S < WINDOW_S:
            self._sums[window] += plate_c
            self._counts[window] += 1
        if not self._calm or not self.needs_test or not WINDOW_S <= at_s < WINDOW_S + 2.0 * PULSE_S:
            return 0.0
        return -self._drive if at_s < WINDOW_S + PULSE_S else self._drive

    def _judge(self) -> None:
        """Judge a completed round: that without drive by its drift, that with drive as the test."""
        first, middle, last = map(truediv, self._sums, self._counts)
        change_k = first + last - 2.0 * middle
        if self._calm:
            self.needs_test = change_k < self._least_k
            self._calm = False
        else:
            self._calm = abs(change_k) <= CALM_SHARE * self._least_k

    def interrupt(self) -> None:
        """Discard the round in progress, as after a standstill; TEST_EVERY_S still counts from a pulse that began."""
        self._began_s = math.nan
        self._calm = False
