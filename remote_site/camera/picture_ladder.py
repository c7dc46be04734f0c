"""Chooses how much picture the network can carry without making touch older.

The ladder gives way when the age of touch, or of the picture itself, has grown above its calm value. It climbs again
after a calm time, which doubles when the step before was too early. At the lowest rung the picture is not the cause of
a larger age: then this age is the new calm value.
"""

import math
from collections import deque
from statistics import median
from typing import NamedTuple


class Rung(NamedTuple):
    """One step of the ladder: shares of the configured size, rate and bit rate."""

    size: float
    rate: float
    bits: float


RUNGS = (Rung(1.0, 1.0, 1.0), Rung(1.0, 0.67, 0.5), Rung(0.5, 0.67, 0.2), Rung(0.5, 0.4, 0.1), Rung(0.25, 0.4, 0.04))
"""Steps from the best picture to the smallest."""
LEAST_HZ = 4.0
"""Least rate of pictures at any step, 1/s: a picture older than `common.limits.FROZEN_S` is no live one."""
WINDOW_S = 1.0
"""Time over which the median of the ages is taken, s; a lost packet alone moves no median."""
CALM_WINDOW_S = 60.0
"""Time over which the calm value is the smallest median, s."""
GROWN = 1.1
"""Ratio of an age to its calm value beyond which the ladder gives way."""
GROWN_S = 0.004
"""Least growth of an age that counts, s; the clocks' uncertainty and a busy machine stay below it."""
STEP_S = 1.0
"""Least time between two steps, s."""
CLIMB_S, LONGEST_CLIMB_S = 5.0, 60.0
"""Calm time before a step up, s, and its longest value after steps that were too early."""
_PICTURE_GROWN_S = 0.15
"""Growth of the picture's own age that counts, s; pictures wait for each other before touch does."""


class _Age:
    """Recent median of an age, and its calm value."""

    def __init__(self) -> None:
        self._recent: deque[tuple[float, float]] = deque()
        self._medians: deque[tuple[float, float]] = deque()

    def take(self, now_s: float, age_s: float) -> None:
        self._recent.append((now_s, age_s))
        while self._recent[0][0] < now_s - WINDOW_S:
            self._recent.popleft()
        middle_s = median(age for _, age in self._recent)
        while self._medians and self._medians[-1][1] >= middle_s:
            self._medians.pop()
        self._medians.append((now_s, middle_s))
        while self._medians[0][0] < now_s - CALM_WINDOW_S:
            self._medians.popleft()
        self._now_s, self._middle_s = now_s, middle_s

    def grown(self, ratio: float, least_s: float) -> bool:
        if not self._medians:
            return False
        calm_s = self._medians[0][1]
        return self._middle_s > max(ratio * calm_s, calm_s + least_s)

    def accept(self) -> None:
        """Make the present age the calm one."""
        if self._medians:
            self._medians = deque([(self._now_s, self._middle_s)])


class PictureLadder:
    """The ladder of one camera. Pure: times are arguments, s.

    Attributes:
        number: index of the present rung in RUNGS.
    """

    def __init__(self) -> None:
        self.number = 0
        self._touch, self._picture = _Age(), _Age()
        self._stepped_s = self._calm_since_s = self._climbed_s = -math.inf
        self._wait_s = CLIMB_S

    @property
    def rung(self) -> Rung:
        """The present rung."""
        return RUNGS[self.number]

    def step(self, now_s: float, touch_age_s: float, picture_age_s: float) -> None:
        """Take the largest age of touch since the last step and that of the newest picture when it was received, s.

        An age is 0 where it is not known.
        """
        if touch_age_s > 0.0:
            self._touch.take(now_s, touch_age_s)
        if picture_age_s > 0.0:
            self._picture.take(now_s, picture_age_s)
        if self._touch.grown(GROWN, GROWN_S) or self._picture.grown(1.0, _PICTURE_GROWN_S):
            self._calm_since_s = now_s
            if now_s - self._stepped_s >= STEP_S:
                self._give_way(now_s)
        elif self.number and now_s - max(self._calm_since_s, self._stepped_s) >= self._wait_s:
            self.number -= 1
            self._stepped_s = self._climbed_s = now_s

    def _give_way(self, now_s: float) -> None:
        self._stepped_s = now_s
        if self.number == len(RUNGS) - 1:
            self._touch.accept()
            self._picture.accept()
            return
        self.number += 1
        early = now_s - self._climbed_s < 2.0 * CLIMB_S
        self._wait_s = min(2.0 * self._wait_s, LONGEST_CLIMB_S) if early else CLIMB_S
