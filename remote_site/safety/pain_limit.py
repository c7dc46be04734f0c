"""Lowers the remote force limit to the patient's own pain threshold.

The limit is a share of the lowest force at which the patient has reported pain. Only a person ends it.
"""

import math
from collections import deque
from collections.abc import Sequence

from common.limits import PAIN_LEAST_N, PAIN_SHARE
from common.tenderness.pain_report import MOST_REPORTS, PainReport
from common.tenderness.presses import LATEST_S, PRESSED_N, Press, PressFinder
from common.tenderness.reaction import ReactionTime

REPORTED_SHARE, ENDED_SHARE = 0.9, 0.5
"""Quantiles of the patient's threshold that count when a report begins, and when it has ended.

The reaction time is known better after the end. The first limit is high enough for the second one to lower it."""


class PainLimit:
    """Follows the patient's threshold.

    Attributes:
        limit_n: greatest contact force, N; infinite before the first report of pain.
        finder: the newest presses.
        reaction: the patient's reaction time.
        reports: the newest reports of pain, oldest first.
    """

    def __init__(self, presses: int = 8) -> None:
        self.limit_n = math.inf
        self._lowered_s = -math.inf
        self.reaction = ReactionTime()
        self.finder = PressFinder(presses)
        self.reports: deque[PainReport] = deque(maxlen=MOST_REPORTS)

    def step(
        self, t_s: float, force_n: Sequence[float], x_m: Sequence[float], y_m: Sequence[float], answer: float
    ) -> None:
        """Take forces, N, places, m, and the newest pain answer, 0..10 or NaN, at a time, s.

        Where the pain outlasts the longest reaction time and a finger still presses, the limit becomes lower again.
        """
        press = self.finder.step(t_s, force_n, x_m, y_m, answer)
        if press is None:
            if self.finder.hurts and t_s - self._lowered_s >= LATEST_S:
                # A report that is too early for its press has set no limit; the present forces are the only ones known.
                lightest_n = min((newton for newton in force_n if newton >= PRESSED_N), default=0.0)
                self._lower(t_s, lightest_n if self.limit_n == math.inf else self.limit_n)
            return
        share = REPORTED_SHARE
        if not math.isnan(press.fallen_s):
            self.reaction.learn(press)
            share = ENDED_SHARE
            self.reports.pop()
        self.reports.append(self._report(press))
        self._lower(t_s, self.reaction.threshold_n(press, share))

    def _lower(self, t_s: float, threshold_n: float) -> None:
        self.limit_n = min(self.limit_n, max(PAIN_LEAST_N, PAIN_SHARE * threshold_n))
        self._lowered_s = t_s

    def _report(self, press: Press) -> PainReport:
        finger = press.peak_n.index(max(press.peak_n))
        threshold_n = self.reaction.threshold_n(press, ENDED_SHARE)
        return PainReport(press.x_m[finger], press.y_m[finger], threshold_n, press.answer)

    def end(self) -> None:
        """Return to the default limit: a deliberate act of a person. What is known of the reaction is kept."""
        self.limit_n = math.inf
