"""One answer for all fingers on one object, and each its own where that does not hold."""

from dataclasses import replace

import numpy as np
import pytest

from common.wire.messages import ThermalReason, ThermalStatus
from remote_site.thermal.shared_object import SharedObject
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalResult
from tests.unit.remote_site.made_touches import MadeTouch, made_touches
from tests.unit.remote_site.played_touches import Hand, names


def same(name: str, seed: int, seconds: float = 3.0) -> list[MadeTouch]:
    return made_touches(name, 2, seed, seconds, start_c=(33.0, 37.0), same_piece=True)


def first_name(answers: list[ThermalResult | None]) -> int | None:
    return next((k for k, answer in enumerate(answers) if answer is not None and answer.material), None)


def test_one_finger_speaks_for_itself(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 1)[:1])
    assert set(hand.play(0.5)) == {None}
    assert SharedObject(knowledge).step({}) is None


def test_two_fingers_name_it_earlier_than_each_alone(knowledge: ThermalKnowledge) -> None:
    joint_s, alone_s = [], []
    for name in ("metal", "stone", "plastic"):
        hand = Hand(knowledge, same(name, 3))
        found = hand.play()
        assert names(found) == {name}
        joint_s.append(first_name(found))
        alone_s.extend(first_name([*each]) or 300 for each in hand.alone.values())
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
    assert Hand(knowledge, touches).play()[-1] is None


@pytest.mark.long
def test_a_joint_result_stays_when_the_touch_is_over(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 5, 2.5))
    answer = hand.play()[-1]
    for finger in hand.fingers.values():
        finger.stop(ThermalReason.CONTACT_LOST)
    kept = hand.shared.step(hand.fingers)
    assert [said is not None and said.material for said in (answer, kept)] == ["stone", "stone"]


def test_a_touch_that_ends_undecided_leaves_each_finger_its_reason(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 6))
    hand.play(0.15)
    for finger in hand.fingers.values():
        finger.stop(ThermalReason.CONTACT_LOST)
    assert hand.shared.step(hand.fingers) is None
    assert {finger.answer.reason for finger in hand.fingers.values()} == {ThermalReason.CONTACT_LOST}


@pytest.mark.parametrize("lasts_s", [0.3, 0.33])
def test_fingers_whose_readings_end_undecided_keep_one_ambiguous_answer(
    knowledge: ThermalKnowledge, lasts_s: float
) -> None:
    brief = ThermalKnowledge.of(knowledge.table.model_copy(update={"lasts_s": lasts_s}))
    hand = Hand(brief, same("stone", 6, 1.0))
    for finger in hand.fingers.values():
        finger.alone = False
    answers = hand.play()
    assert not any(finger.running for finger in hand.fingers.values())
    assert {answer and answer.status for answer in answers[-60:]} == {ThermalStatus.AMBIGUOUS}
    own = [finger.answer for finger in hand.fingers.values()]
    assert {answer.status for answer in own} == {ThermalStatus.AMBIGUOUS}
    joint = answers[-1]
    assert joint is not None
    assert [answer.object_c for answer in own] == pytest.approx([joint.object_c] * 2, abs=2.0)


def test_a_finger_whose_sensor_fails_at_once_does_not_count(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, same("stone", 7))
    hand.fingers[1].stop(ThermalReason.SENSOR_OPEN)
    assert set(hand.play(0.5)) == {None}


def test_a_sensor_that_hangs_takes_no_answer_from_the_other_fingers(knowledge: ThermalKnowledge) -> None:
    """Until it is detected, its readings contradict the others for as long as a plate may repeat its reading."""
    sound, hung = same("stone", 3)
    stuck_c = hung.sensor_c[np.searchsorted(hung.time_s, 1.2)]
    hung = replace(hung, sensor_c=np.where(hung.time_s >= 1.2, stuck_c, hung.sensor_c))
    hand = Hand(knowledge, [sound, hung])
    answer = hand.play()[-1]
    assert not hand.fingers[1].running
    assert answer is not None
    assert (answer.best, answer.reason) == ("stone", ThermalReason.NONE)
    assert answer.object_c == pytest.approx(sound.object_c, abs=0.5)


@pytest.mark.long
@pytest.mark.parametrize("stays", [False, True], ids=["all leave", "one by one"])
def test_the_next_object_is_judged_separately(knowledge: ThermalKnowledge, stays: bool) -> None:
    """Fingers may change one by one: one always touches, and the answer for the object before must not stay."""
    hand, after = Hand(knowledge, same("stone", 8, 2.5)), Hand(knowledge, same("plastic", 9, 2.5))
    hand.play()
    last = hand.shared.step({0: hand.fingers[0]} if stays else {})
    assert (last is not None) == stays
    assert last is None or last.material == "stone", "the finger that stays keeps what all of them said last"
    after.shared = hand.shared
    answers = after.play()
    assert answers[0] is not None
    assert answers[0].status is ThermalStatus.DECIDING
    assert names(answers) == {"plastic"}
    assert answers[-1] is not None
    assert answers[-1].material == "plastic"
