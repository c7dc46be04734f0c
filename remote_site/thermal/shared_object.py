"""Fingers that touch at the same time usually touch one object: what they know of it together.

Each finger's own evidence stays its own; only where one object explains all of them is one answer given to all.
"""

from collections.abc import Mapping

from common.wire.messages import ThermalStatus
from remote_site.thermal.contact_change import NEARLY_S
from remote_site.thermal.solving_turns import NOTHING_DUE, POSTPONED_S
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalConclusion, ThermalResult

ONE_OBJECT = 0.5
"""Probability from which the fingers count as touching one object."""
JUDGE_EVERY_S = 0.04
"""Between two judgements, s, at least: the fingers have to be solved anew."""
DOUBT_EVERY_S = 0.10
"""Between two looks at whether it is one object, s."""


class SharedObject:
    """Joint judgement of a hand; step it, or look at it, after its fingers.

    Attributes:
        waited_s: POSTPONED_S while a judgement is due, so that a late tick does not postpone it; below 0 otherwise.
    """

    def __init__(self, knowledge: ThermalKnowledge) -> None:
        """Judge with `knowledge`."""
        self._knowledge = knowledge
        self._release()

    def _release(self) -> None:
        self._conclusion: ThermalConclusion | None = None
        self._answer: ThermalResult | None = None
        self._count = 0
        self._judged_s = self._doubted_s = -1.0
        self._one = True
        self.waited_s = NOTHING_DUE
        self._touching: list[ThermalIdentification] = []

    def step(self, fingers: Mapping[int, ThermalIdentification]) -> ThermalResult | None:
        """Judge if that is due, and return the answer that holds for all fingers in contact; see `look`."""
        self.look(fingers)
        self.work()
        return self.look(fingers)

    def look(self, fingers: Mapping[int, ThermalIdentification]) -> ThermalResult | None:
        """The answer that holds for all fingers in contact; None where each has to speak for itself.

        Args:
            fingers: the identification of each finger in contact.
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
        solved = longest_s - self._judged_s >= JUDGE_EVERY_S - NEARLY_S and all(
            finger.fresh or not finger.running for finger in touching
        )
        # Where one has left, the others keep what was last said of all: together they know no more than then.
        due = running and len(touching) >= max(2, self._count) and (solved or len(touching) > self._count)
        self._touching, self.waited_s = touching, POSTPONED_S if due else NOTHING_DUE
        if self._answer is None or not self._one:
            return None
        return self._answer if running or self._answer.status is not ThermalStatus.DECIDING else None

    def work(self) -> None:
        """Judge the hand as it was when last looked at, if that is due."""
        if self.waited_s < 0.0:
            return
        touching = self._touching
        longest_s = max(finger.since_s for finger in touching)
        self._judged_s, self._count, self.waited_s = longest_s, len(touching), NOTHING_DUE
        for finger in touching:
            finger.fresh = False
        self._judge(touching, longest_s)

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
