"""Joins touch packets with the patient's pain answers into presses, live and from a recording."""

import copy
import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from common.fingers import FINGER_Y_M
from common.tenderness.pain_report import MOST_REPORTS, PainReport
from common.tenderness.presses import LATEST_S, Press, PressFinder
from common.tenderness.reaction import ReactionTime
from common.wire.messages import TouchRow

MOST_PRESSES = 400
"""Number of the newest presses that are kept."""
ANSWER_OLD_S = 2.0
"""Age from which a live answer counts as unknown, s."""
SETTLED_S = LATEST_S + 1.0
"""Time after a press in which a report of pain may still arrive, s: the longest reaction time and 1 s of the link."""
MEDIAN = 0.5
"""Quantile of the threshold in a report."""


class Presses(NamedTuple):
    """Presses with a known answer, and the reaction time that they show; the search for a place takes both."""

    presses: list[Press]
    reaction: ReactionTime


class PainPresses:
    """Presses of one examination. Pure; it can be pickled.

    Attributes:
        answered: whether the patient has a pain slider.
        revision: grows with each report of pain, with each end of one, and with each settled press.
        reports: the newest reports of pain, oldest first.
    """

    def __init__(self, oldest_s: float = ANSWER_OLD_S) -> None:
        """Begin without a slider; an answer counts for `oldest_s`, s."""
        self.answered = False
        self.revision = 0
        self.reports: deque[PainReport] = deque(maxlen=MOST_REPORTS)
        self._oldest_s = oldest_s
        self._finder = PressFinder(MOST_PRESSES)
        self._reaction = ReactionTime()
        self._answer_s = -math.inf
        self._answer = math.nan
        self._unsettled: deque[Press] = deque()
        """Presses that have ended without pain and whose report may still arrive, oldest first."""

    def take_touch(self, t_s: float, rows: Sequence[TouchRow]) -> None:
        """Take the touch rows of an accepted packet at a time, s."""
        if not self.answered:
            return
        if math.isnan(self._answer) or t_s - self._answer_s > self._oldest_s:
            self._finder.drop()
            return
        force_n = [row.contact_force_n for row in rows]
        y_m = [row.y_m + along_m for row, along_m in zip(rows, FINGER_Y_M, strict=True)]
        was_open = self._finder.open
        self._finder.touch(t_s, force_n, [row.x_m for row in rows], y_m)
        if was_open and not self._finder.open:
            self._unsettled.append(self._finder.presses[-1])
        while self._unsettled and t_s - self._unsettled[0].time_s[-1] >= SETTLED_S:
            press = self._unsettled.popleft()
            self.revision += 1
            if not press.painful:
                del press.time_s[1:-1], press.force_n[1:-1]  # only its peak counts

    def take_answer(self, t_s: float, answer: float | None, polled: bool) -> None:
        """Take an answer, 0..10, None while it is unknown, at a time, s.

        A polled answer has changed at some time since the one before; the middle is assumed.
        """
        since_s = min(t_s - self._answer_s, self._oldest_s) if polled and self.answered else 0.0
        self.answered = True
        self._answer_s, self._answer = t_s, math.nan if answer is None else answer
        press = self._finder.answer(t_s - 0.5 * since_s, self._answer)
        if press is None:
            return
        self.revision += 1
        if not math.isnan(press.fallen_s):
            self._reaction.learn(press)
            self.reports.pop()
        finger = press.peak_n.index(max(press.peak_n))
        threshold_n = self._reaction.threshold_n(press, MEDIAN)
        self.reports.append(PainReport(press.x_m[finger], press.y_m[finger], threshold_n, press.answer))

    def settled(self, *, final: bool = False) -> Presses:
        """Return copies of the presses with pain, and those whose report can no longer arrive, which stay as they are.

        At the end of a recording, `final`, no further report arrives.
        """
        waiting = [] if final else [id(press) for press in self._unsettled]
        if self._finder.open:
            waiting.append(id(self._finder.presses[-1]))
        found = [press for press in self._finder.presses if press.painful or id(press) not in waiting]
        return Presses([_copy(press) if press.painful else press for press in found], copy.copy(self._reaction))


def _copy(press: Press) -> Press:
    return replace(press, time_s=[*press.time_s], force_n=[*press.force_n])


def quiet_places(presses: Iterable[Press]) -> list[tuple[float, float, float]]:
    """Return x and y, m, of each finger that pressed without pain, and its greatest force, N."""
    return [
        place
        for press in presses
        if not press.painful
        for place in zip(press.x_m, press.y_m, press.peak_n, strict=True)
        if place[2] > 0.0
    ]
