"""Joins the evidence of fingers that touch at the same time, because they usually touch one object.

Each finger keeps its own evidence. All fingers get one answer only if one object explains all of their evidence.
"""

from collections.abc import Mapping

from common.wire.messages import ThermalStatus
from remote_site.thermal.contact_change import NEARLY_S
from remote_site.thermal.solving_turns import NOTHING_DUE, POSTPONED_S
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalConclusion, ThermalResult

ONE_OBJECT = 0.5
"""Minimum probability of one object for a joint answer."""
JUDGE_EVERY_S = 0.04
"""Minimum interval between two judgements, s; each needs new solutions of the fingers."""
DOUBT_EVERY_S = 0.10
"""Interval between two tests for one object, s."""


class SharedObject:
    """Joint judgement of a hand; call `step`, or `look`, after its fingers.

    Attributes:
        waited_s: POSTPONED_S while a judgement is due, so that a late tick does not postpone it; negative otherwise.
    """

    def __init__(self, knowledge: ThermalKnowledge) -> None:
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
        """Judge if due, and return the answer for all fingers in contact; see `look`."""
        self.look(fingers)
        self.work()
        return self.look(fingers)

    def look(self, fingers: Mapping[int, ThermalIdentification]) -> ThermalResult | None:
        """Return the answer for all fingers in contact; None if each finger answers for itself."""
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
        if longest_s < self._judged_s:  # the fingers of the previous touch have left one by one
            self._release()
        if running:
            solved = all(finger.fresh or not finger.running for finger in touching)
            due = len(touching) > self._count or (solved and longest_s - self._judged_s >= JUDGE_EVERY_S - NEARLY_S)
        else:  # their last solutions count, too
            due = any(finger.fresh for finger in touching)
        # After a finger has left, the others keep the last joint answer, since they have no more evidence than it had.
        due = due and len(touching) >= max(2, self._count)
        self._touching, self.waited_s = touching, POSTPONED_S if due else NOTHING_DUE
        if self._answer is None or not self._one:
            return None
        return self._answer if running or self._answer.status is not ThermalStatus.DECIDING else None

    def work(self) -> None:
        """Judge the hand as of the last `look`, if due."""
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
        # A plate that was still heated at contact would mislead the others; alone it counts.
        judges = [finger for finger in touching if finger.rested] or touching
        evidence = {finger: found for finger in judges if (found := finger.evidence()) is not None}
        if not evidence:
            return
        doubt = longest_s - self._doubted_s >= DOUBT_EVERY_S
        posterior = self._knowledge.posterior.judge(list(evidence.values()), compare=doubt)
        if doubt:
            self._doubted_s, self._one = longest_s, posterior.same_object >= ONE_OBJECT
        longest = max(evidence, key=lambda finger: finger.since_s)
        self._answer = longest.with_exponential(self._conclusion.step(posterior, longest_s, list(evidence)))
