"""Fingers that touch at the same time usually touch one object: what they know of it together.

Each finger's own evidence stays its own; only where one object explains all of them is one answer given to all.
"""

from collections.abc import Mapping

from common.messages import ThermalStatus
from remote_site.late_ticks import POSTPONED_S
from remote_site.thermal_answer import ThermalAnswer, ThermalConclusion
from remote_site.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.touch_estimate import solve_interval_s

ONE_OBJECT = 0.5
"""Probability from which the fingers count as touching one object."""
JUDGE_EVERY_S = 0.04
"""Between two judgements, s; longer where the fingers solve their guesses more seldom."""
DOUBT_EVERY_S = 0.10
"""Between two looks at whether it is one object, s."""


class SharedObject:
    """Joint judgement of a hand; step it after its fingers."""

    def __init__(self, knowledge: ThermalKnowledge) -> None:
        """Judge with `knowledge`."""
        self._knowledge = knowledge
        self._release()

    def _release(self) -> None:
        self._conclusion: ThermalConclusion | None = None
        self._answer: ThermalAnswer | None = None
        self._count = 0
        self._judged_s = self._doubted_s = -1.0
        self._one = True

    def step(self, fingers: Mapping[int, ThermalIdentification], hurry: bool = False) -> ThermalAnswer | None:
        """The answer that holds for all fingers in contact; None where each has to speak for itself.

        Args:
            fingers: the identification of each finger in contact.
            hurry: whether a judgement that is due shall wait, for POSTPONED_S at most.
        """
        touching: list[ThermalIdentification] = []
        longest_s, running = 0.0, False
        for finger in fingers.values():
            if (since_s := finger.since_s) > 0.0:
                touching.append(finger)
                running = running or finger.running
                longest_s = max(longest_s, since_s)
        if not touching:
            if self._count:
                self._release()
            return None
        if longest_s < self._judged_s:  # the fingers of the touch before have left one by one
            self._release()
        solved_every_s = solve_interval_s(longest_s, self._knowledge.solve_every_s)
        every_s = max(solved_every_s, JUDGE_EVERY_S) + (POSTPONED_S if hurry else 0.0)
        due = longest_s - self._judged_s >= every_s - 1e-9 or (len(touching) > self._count and not hurry)
        # Where one has left, the others keep what was last said of all: together they know no more than then.
        if len(touching) >= max(2, self._count) and running and due:
            self._judged_s, self._count = longest_s, len(touching)
            self._judge(touching, longest_s)
        if self._answer is None or not self._one:
            return None
        return self._answer if running or self._answer.status is not ThermalStatus.DECIDING else None

    def _judge(self, touching: list[ThermalIdentification], longest_s: float) -> None:
        if self._conclusion is None:
            self._conclusion = self._knowledge.conclusion()
        # A plate that was still being heated would mislead the others, unless there are no others.
        judges = [finger for finger in touching if finger.rested] or touching
        evidence = [found for finger in judges if (found := finger.evidence()) is not None]
        if not evidence:
            return
        doubt = longest_s - self._doubted_s >= DOUBT_EVERY_S
        posterior = self._knowledge.posterior.judge(evidence, compare=doubt)
        if doubt:
            self._doubted_s, self._one = longest_s, posterior.same_object >= ONE_OBJECT
        longest = max(touching, key=lambda finger: finger.since_s)
        self._answer = longest.with_exponential(self._conclusion.step(posterior, longest_s))
