"""Keeps a plate off that faults name repeatedly, until a small test pulse moves it as it moves a sound plate.

The first fault is cleared by a person alone. After a further one within REPEATED_S the plate gets no drive but the
test's: a round without any, to see what moves by itself, then a round that cools and heats by the same small amount.
The reading's second difference over a round leaves out any steady drift. A stuck reading or a dead heater shows
nothing in it, a reversed drive the wrong sign. A test that fails is repeated after TEST_EVERY_S at the earliest.
"""

import math
from operator import truediv

REPEATED_S = 600.0
"""A fault of the same plate within this time of the one before needs a test, s."""
TEST_EVERY_S = 30.0
"""Time from the start of one test pulse to the next, s."""
PULSE_S = 0.5
"""Cooling, and then heating, each for this long, s."""
WINDOW_S = 0.2
"""The reading is averaged over this time at the start, after the cooling and at the end of a round, s."""
SPACING_S = PULSE_S + 0.2
"""From one average to the next, s: a reading is 0.1 s to 0.2 s behind the drive."""
ROUND_S = 2.0 * SPACING_S + WINDOW_S
CALM_SHARE = 0.5
"""Without drive the reading may show at most this share of what the test needs."""


class RepeatedFault:
    """One plate's faults and tests. Pure: times and readings in, drive out."""

    def __init__(self, drive: float, least_k: float) -> None:
        """A plate that no fault has named.

        Args:
            drive: of the test pulse, 0..1 of full drive.
            least_k: second difference of the reading that a sound plate exceeds in a test, K.
        """
        self.needs_test = False
        """Whether the plate gets no drive but the test's."""
        self._drive = drive
        self._least_k = least_k
        self._named_s: float | None = None
        self._next_s = -math.inf
        self._began_s: float
        self._calm: bool
        self._sums: list[float] = []
        self._counts: list[int] = []
        """Of the round; a round begins with zeros."""
        self.interrupt()

    def named(self, t_s: float) -> bool:
        """A fault names this plate at a time, s; returns whether it needs a test now."""
        # After a clock was set back it is not known to be long ago, and neither is it without a time.
        if self._named_s is not None and not t_s - self._named_s > REPEATED_S:
            self.demand_test()
        self._named_s = t_s
        return self.needs_test

    def demand_test(self) -> None:
        """Allow no drive before a test, whatever happened before."""
        self.needs_test = True
        self.interrupt()

    def step(self, t_s: float, plate_c: float, free: bool) -> float:
        """Drive of the test now, -1..1; passing the test ends `needs_test`.

        Args:
            t_s: time, s.
            plate_c: reading of the plate, C; NaN where there is none.
            free: whether the plate may be driven. Between two steps less than 0.1 s pass, else `interrupt`.
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
        """A round has ended: it was calm without drive, or it was the test."""
        first, middle, last = map(truediv, self._sums, self._counts)
        change_k = first + last - 2.0 * middle
        if self._calm:
            self.needs_test = change_k < self._least_k
            self._calm = False
        else:
            self._calm = abs(change_k) <= CALM_SHARE * self._least_k

    def interrupt(self) -> None:
        """What was seen so far of a test is forgotten, as after a standstill; a pulse that began counts as one."""
        self._began_s = math.nan
        self._calm = False
