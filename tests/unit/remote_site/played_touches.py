"""Made-up touches played to thermal identification: to one finger, to a hand, and to the filters of one touch alone."""

import math
from collections.abc import Callable, Iterable

from remote_site.thermal.shared_object import SharedObject
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalResult
from remote_site.thermal.touch_estimate import TouchEstimate, TouchEvidence
from tests.unit.remote_site.made_touches import AMBIENT_C, MadeTouch

Change = Callable[[float, float, float], tuple[float, float, float]]
"""Makes of a reading's time, s, temperature, C, and force, N, what is read in its place."""


def touching(knowledge: ThermalKnowledge, touch: MadeTouch) -> ThermalIdentification:
    """One finger at contact."""
    finger = ThermalIdentification(knowledge)
    finger.start(0.0, touch.start_c, 0.0, AMBIENT_C)
    return finger


def play(knowledge: ThermalKnowledge, touch: MadeTouch, change: Change | None = None) -> list[ThermalResult]:
    """Answers of one finger after every reading."""
    finger = touching(knowledge, touch)
    return [finger.step(*(row if change is None else change(*row))) for row in touch.after()]


def names(answers: Iterable[ThermalResult | None]) -> set[str]:
    """All materials that were named."""
    return {answer.material for answer in answers if answer is not None and answer.material is not None}


class Hand:
    """Fingers that are stepped together, then judged together.

    Attributes:
        alone: own answers of each finger after every reading.
    """

    def __init__(self, knowledge: ThermalKnowledge, touches: list[MadeTouch]) -> None:
        self.shared = SharedObject(knowledge)
        self.touches = touches
        self.fingers = {number: touching(knowledge, touch) for number, touch in enumerate(touches)}
        self.alone: dict[int, list[ThermalResult]] = {number: [] for number in self.fingers}

    def play(self, until_s: float = math.inf) -> list[ThermalResult | None]:
        """Joint answers after every reading."""
        answers = []
        for rows in zip(*(touch.after() for touch in self.touches), strict=True):
            if rows[0][0] > until_s + 1e-9:
                break
            for number, row in enumerate(rows):
                self.alone[number].append(self.fingers[number].step(*row))
            answers.append(self.shared.step(self.fingers))
        return answers


def estimated(
    knowledge: ThermalKnowledge, touch: MadeTouch, slope_k_s: float = 0.0, shift_c: float = 0.0
) -> TouchEvidence:
    """What the filters say of a touch, all of whose temperatures may be shifted."""
    found = TouchEstimate(
        knowledge.table,
        knowledge.substances,
        knowledge.guesses,
        touch.start_c + shift_c,
        slope_k_s,
        touch.ambient_c + shift_c,
    )
    before_s = 0.0
    for t_s, sensor_c, force_n in touch.after():
        found.take(t_s - before_s, sensor_c + shift_c, force_n)
        found.work()
        before_s = t_s
    found.settle()
    return found.evidence()
