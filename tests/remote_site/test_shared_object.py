"""One answer for all fingers on one object, and each its own where that does not hold."""

from common.messages import ThermalStatus
from remote_site.shared_object import SharedObject
from remote_site.thermal_answer import ThermalAnswer
from remote_site.thermal_identification import ThermalIdentification, ThermalKnowledge
from tests.remote_site.made_touches import AMBIENT_C, MadeTouch, made_touches

STAGGERED_C = (33.0, 37.0)


class Hand:
    """Fingers that are stepped together, then judged together."""

    def __init__(self, knowledge: ThermalKnowledge, touches: list[MadeTouch]) -> None:
        self.shared = SharedObject(knowledge)
        self.fingers = {number: ThermalIdentification(knowledge) for number in range(len(touches))}
        self.touches = touches
        for finger, touch in zip(self.fingers.values(), touches, strict=True):
            finger.start(0.0, touch.start_c, 0.0, AMBIENT_C)

    def play(self, until_s: float) -> list[ThermalAnswer | None]:
        """Joint answers after every reading."""
        answers = []
        for rows in zip(*(touch.after() for touch in self.touches), strict=True):
            t_s = rows[0][0]
            if t_s > until_s + 1e-9:
                break
            for number, row in enumerate(rows):
                self.fingers[number].step(*row)
            answers.append(self.shared.step(self.fingers))
        return answers


def same(name: str, seed: int, seconds: float = 3.0) -> list[MadeTouch]:
    return made_touches(name, 2, seed, seconds, start_c=STAGGERED_C, same_piece=True)


def first_name(answers: list[ThermalAnswer | None]) -> int | None:
    return next((k for k, answer in enumerate(answers) if answer is not None and answer.material), None)


def test_one_finger_speaks_for_itself(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 1)[:1])
    assert set(hand.play(0.5)) == {None}
    assert SharedObject(knowledge).step({}) is None


def test_two_fingers_name_it_earlier_than_each_alone(knowledge: ThermalKnowledge) -> None:
    joint_s, alone_s = [], []
    for name in ("metal", "stone", "plastic"):
        hand = Hand(knowledge, same(name, 3))
        found: list[ThermalAnswer | None] = []
        alone: list[list[ThermalAnswer | None]] = [[], []]
        rows = [touch.after() for touch in hand.touches]
        for k in range(300):
            for number, finger in hand.fingers.items():
                alone[number].append(finger.step(*rows[number][k]))
            found.append(hand.shared.step(hand.fingers))
        named = {answer.material for answer in found if answer is not None} - {None}
        assert named == {name}
        joint_s.append(first_name(found))
        alone_s.extend(first_name(each) or 300 for each in alone)
    assert None not in joint_s
    assert sum(k or 0 for k in joint_s) / 3 < 0.7 * sum(alone_s) / 6


def test_the_joint_answer_carries_the_papers_method_of_one_finger(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("metal", 3))
    answer = hand.play(2.0)[-1]
    assert answer is not None
    assert answer.exponential_material is not None
    assert answer.rate_per_s is not None
    rates = [finger.answer.rate_per_s or 0.0 for finger in hand.fingers.values()]
    assert 0.9 * min(rates) < answer.rate_per_s < 1.1 * max(rates)


def test_on_different_objects_each_finger_speaks_for_itself(knowledge: ThermalKnowledge) -> None:
    touches = [made_touches(name, 1, 4, 2.0)[0] for name in ("metal", "plastic")]
    assert Hand(knowledge, touches).play(2.0)[-1] is None


def test_what_was_found_together_stays_when_the_touch_is_over(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 5, 2.5))
    answer = hand.play(2.5)[-1]
    assert answer is not None
    assert answer.material == "stone"
    for finger in hand.fingers.values():
        finger.stop("contact lost")
    kept = hand.shared.step(hand.fingers)
    assert kept is not None
    assert kept.material == "stone"


def test_a_touch_that_ends_undecided_leaves_each_finger_its_reason(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 6))
    hand.play(0.15)
    for finger in hand.fingers.values():
        finger.stop("contact lost")
    assert hand.shared.step(hand.fingers) is None
    assert {finger.answer.reason for finger in hand.fingers.values()} == {"contact lost"}


def test_a_finger_whose_sensor_fails_at_once_does_not_count(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 7))
    hand.fingers[1].stop("sensor fault: open")
    assert set(hand.play(0.5)) == {None}


def test_the_next_object_is_judged_anew(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 8, 2.5))
    hand.play(2.5)
    assert hand.shared.step({}) is None
    again = Hand(knowledge, same("plastic", 9, 2.5))
    again.shared = hand.shared
    answers = again.play(2.5)
    first = answers[0]
    assert first is not None
    assert first.status is ThermalStatus.DECIDING
    assert {answer.material for answer in answers if answer is not None} <= {None, "plastic"}
    assert answers[-1] is not None
    assert answers[-1].material == "plastic"


def test_fingers_that_change_one_by_one_do_not_keep_the_old_answer(knowledge: ThermalKnowledge) -> None:
    """One finger always touches: the answer of the object before must not stand for the next one."""
    hand = Hand(knowledge, same("stone", 8, 2.5))
    hand.play(2.5)
    after = Hand(knowledge, same("plastic", 9, 2.5))
    last = hand.shared.step({0: hand.fingers[0]})
    assert last is not None, "the finger that stays keeps what all of them said last"
    assert last.material == "stone"
    after.shared = hand.shared
    answers = after.play(2.5)
    assert {answer.material for answer in answers if answer is not None} <= {None, "plastic"}
    assert answers[-1] is not None
    assert answers[-1].material == "plastic"
