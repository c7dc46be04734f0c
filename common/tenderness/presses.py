"""Joins contact forces and the patient's pain answers into presses."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WORST_PAIN = 10.0
"""End of the scale of pain answers."""
PAINFUL = 0.5
"""Lowest pain answer that counts as pain, on the scale 0..10; smallest increase of a pain from before a press."""
PRESSED_N, LEFT_N = 0.3, 0.15
"""Forces at which a press begins and ends, N."""
SOONEST_S, LATEST_S = 0.3, 1.2
"""Shortest and longest reaction time of a patient, s."""
SAMPLE_S = 0.02
"""Shortest time between two kept samples, s."""
LONGEST_S = 20.0
"""Longest press, s; a longer one is split."""


@dataclass(slots=True)
class Press:
    """One contact, from the first touch of a finger to the last.

    Attributes:
        time_s: times of the samples, s, increasing.
        force_n: force of each finger in each sample, N.
        x_m, y_m: place of each finger at its greatest force, m.
        peak_n: greatest force of each finger, N.
        risen_s: time at which the patient began to report pain, s; NaN without a report.
        fallen_s: time at which the report ended, s; NaN before.
        answer: highest pain answer of the report, 0..10.
    """

    time_s: list[float]
    force_n: list[tuple[float, ...]]
    x_m: list[float]
    y_m: list[float]
    peak_n: list[float]
    risen_s: float = math.nan
    fallen_s: float = math.nan
    answer: float = 0.0

    @property
    def painful(self) -> bool:
        """Whether the patient reported pain."""
        return not math.isnan(self.risen_s)

    def forces_n(self, t_s: Floats) -> Floats:
        """Return the force of each finger at given times, s, shape (times, fingers); 0 N outside the press."""
        known = np.array(self.force_n)
        columns = [np.interp(t_s, self.time_s, column, left=0.0, right=0.0) for column in known.T]
        return np.stack(columns, axis=-1)


class PressFinder:
    """Finds presses, sample by sample.

    Attributes:
        presses: the newest presses, oldest first; the newest may not have ended.
        open: whether the newest press has not ended.
    """

    def __init__(self, presses: int) -> None:
        self.presses: deque[Press] = deque(maxlen=presses)
        self.open = self._painful = False
        self._reported: Press | None = None
        self._before = 0.0
        """Answer that no press has caused."""

    @property
    def hurts(self) -> bool:
        """Whether a finger presses while the patient reports more pain than before every press."""
        return self.open and self._painful

    def step(
        self, t_s: float, force_n: Sequence[float], x_m: Sequence[float], y_m: Sequence[float], answer: float
    ) -> Press | None:
        """Take a sample; return the press whose report begins or ends with it.

        Args:
            t_s: time, s, increasing.
            force_n: contact force of each finger, N, finite.
            x_m, y_m: place of each finger, m.
            answer: newest pain answer, 0..10; NaN where it is unknown, which changes no report.
        """
        self.touch(t_s, force_n, x_m, y_m)
        return self.answer(t_s, answer)

    def answer(self, t_s: float, answer: float) -> Press | None:
        """Take an answer alone, 0..10 or NaN, given at a time, s; return as `step` does."""
        if self._reported is not None and answer > self._reported.answer:
            self._reported.answer = answer
        if math.isnan(answer):
            return None
        self._before = min(self._before, answer)
        painful = answer >= self._before + PAINFUL
        if painful == self._painful:
            return None
        if painful:
            reported = self._reported_at(t_s)
            if reported is None and not self.open:
                self._before = answer
                return None
            self._painful, self._reported = True, reported
            if reported is not None:
                reported.risen_s, reported.answer = t_s, answer
            return reported
        self._painful = False
        ended, self._reported = self._reported, None
        if ended is not None:
            ended.fallen_s = t_s
        return ended

    def drop(self) -> None:
        """Forget the press that has not ended, because nobody knows whether it hurts."""
        if self.open:
            self.presses.pop()
        self.open, self._reported = False, None

    def touch(self, t_s: float, force_n: Sequence[float], x_m: Sequence[float], y_m: Sequence[float]) -> None:
        """Take forces, N, and places, m, alone."""
        strongest_n = max(force_n)
        if not self.open:
            if strongest_n < PRESSED_N:
                return
            self.open = True
            self.presses.append(Press([t_s], [tuple(force_n)], [*x_m], [*y_m], [*force_n]))
            return
        press = self.presses[-1]
        for finger, pressed_n in enumerate(force_n):
            if pressed_n > press.peak_n[finger]:
                press.peak_n[finger], press.x_m[finger], press.y_m[finger] = pressed_n, x_m[finger], y_m[finger]
        self.open = strongest_n >= LEFT_N and t_s - press.time_s[0] < LONGEST_S
        if not self.open or t_s - press.time_s[-1] >= SAMPLE_S:
            press.time_s.append(t_s)
            press.force_n.append(tuple(force_n))

    def _reported_at(self, t_s: float) -> Press | None:
        """Return the press that a report at this time is about; None where none can be."""
        for press in reversed(self.presses):
            if press.time_s[0] <= t_s - SOONEST_S:
                late = not (press is self.presses[-1] and self.open) and press.time_s[-1] < t_s - LATEST_S
                return None if late or press.painful else press
        return None
