"""A tick solves one finger at most, and a late one none for a while; no reading is lost, and no name is wrong."""

import math
from itertools import pairwise

import pytest

from common.fingers import FINGERS
from remote_site.devices.sensor_frame import PlateReading, SensorFrame
from remote_site.thermal.heater_control import OFFSETS_K, STAGGER_K
from remote_site.thermal.shared_object import SharedObject
from remote_site.thermal.solving_turns import LATE, NOTHING_DUE, POSTPONED_S, SolvingTurns
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalResult
from remote_site.thermal.touch_estimate import TouchEstimate
from tests.unit.remote_site.made_touches import AMBIENT_C, MATERIALS, MadeTouch, made_touches
from tests.unit.remote_site.played_touches import touching
from tests.unit.remote_site.shipped_tables import perception

PERIOD_S = 0.002
FIVE = len(FINGERS)


def five_plates(tick: int, contact: int) -> SensorFrame:
    """A hand at rest whose fingers land all at once in the tick `contact`; readings come every fifth tick."""
    after_s = max(tick - contact, 0) * PERIOD_S
    plates: list[PlateReading | None] = [None] * FIVE
    if tick % 5 == 0:
        for finger, stagger_k in enumerate(STAGGER_K):
            sensor_c = AMBIENT_C + (OFFSETS_K[0] + stagger_k) * (0.6 + 0.4 * math.exp(-after_s))
            plates[finger] = PlateReading(sensor_c, AMBIENT_C, "", 2000 * tick, 0)
    forces_n = (1.2 if tick >= contact else 0.0,) * FIVE
    return SensorFrame(5.0 + PERIOD_S * tick, 0.0, 0.0, (0.0,) * FIVE, forces_n, (None,) * FIVE, tuple(plates), None)


class Waiting:
    """Something that has been due for a while, s."""

    def __init__(self, waited_s: float) -> None:
        self.waited_s = waited_s


def turns_of(turns: SolvingTurns, solvers: list[Waiting], ticks: int, period_s: float = PERIOD_S) -> list[int | None]:
    """Which of the solvers has each tick."""
    found = [turns.step(5.0 + period_s * tick, solvers) for tick in range(ticks)]
    return [None if solver is None else [id(each) for each in solvers].index(id(solver)) for solver in found]


def course(knowledge: ThermalKnowledge, touch: MadeTouch, late_until_s: float) -> tuple[list[ThermalResult], int]:
    """Answers to each reading, and in how many late ticks a solution waited."""
    identification, turns, t_s, answers = touching(knowledge, touch), SolvingTurns(PERIOD_S), 0.0, []
    for row in touch.until(4.0).after():
        identification.take(*row)
        for _ in range(2 if row[0] < late_until_s else 5):
            t_s += 2.5 * PERIOD_S if row[0] < late_until_s else PERIOD_S
            if turns.step(t_s, [identification]) is not None:
                identification.work()
        answers.append(identification.answer)
    return answers, turns.postponed


def test_all_that_are_due_have_one_tick_after_the_other() -> None:
    due = [Waiting(0.0) for _ in range(4)]
    due[2].waited_s = -1e-3
    assert turns_of(SolvingTurns(PERIOD_S), due, 7) == [0, 1, 3, 0, 1, 3, 0]


def test_no_finger_has_a_turn_where_nothing_is_due() -> None:
    turns = SolvingTurns(PERIOD_S)
    assert turns_of(turns, [Waiting(NOTHING_DUE)] * 3, 3) == [None] * 3
    assert turns.step(6.0, []) is None
    assert turns.postponed == 0


def test_a_tick_is_late_by_half_a_period() -> None:
    turns, due = SolvingTurns(PERIOD_S), [Waiting(0.5 * POSTPONED_S)]
    times_s = [5.0, 5.002, 5.004, 5.004 + 1.1 * LATE * PERIOD_S, 5.010, 1.0, 1.002]
    late = [turns.step(t_s, due) is None for t_s in times_s]
    assert late == [False, False, False, True, False, False, False]
    assert turns.postponed == 1


def test_late_ticks_solve_fingers_that_have_waited_long() -> None:
    due = [Waiting(0.0), Waiting(POSTPONED_S), Waiting(NOTHING_DUE)]
    turns = SolvingTurns(PERIOD_S)
    assert turns_of(turns, due, 4, 2 * PERIOD_S) == [0, 1, 1, 1]
    due[1].waited_s = -1.0
    assert turns_of(turns, due, 3, 2 * PERIOD_S) == [0, None, None]
    assert turns.postponed == 2


def test_without_a_period_no_tick_is_late() -> None:
    assert turns_of(SolvingTurns(math.inf), [Waiting(0.0)], 3, 10.0) == [0, 0, 0]


@pytest.mark.long
def test_a_tick_solves_one_finger_or_judges_the_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    worked: list[type] = []

    def count(kind: type[TouchEstimate | SharedObject]) -> None:
        plain = kind.work

        def counted(self: TouchEstimate | SharedObject) -> None:
            worked.append(kind)
            plain(self)

        monkeypatch.setattr(kind, "work", counted)

    count(TouchEstimate)
    count(SharedObject)
    identified = perception(FINGERS)
    most, all_work = 0, set[type]()
    for tick in range(500):
        worked.clear()
        identified.step(five_plates(tick, contact=100))
        identified.work()
        most, all_work = max(most, len(worked)), all_work | set(worked)
    assert most == 1
    assert all_work == {TouchEstimate, SharedObject}


@pytest.mark.long
def test_answers_come_later_and_none_is_wrong_with_every_tick_late(knowledge: ThermalKnowledge) -> None:
    for seed, name in enumerate(MATERIALS):
        (touch,) = made_touches(name, 1, seed=700 + seed)
        usual, postponed = course(knowledge, touch, 0.0)
        assert postponed == 0
        late, postponed = course(knowledge, touch, 10.0)
        assert postponed > 100
        changes = [now is not before for before, now in pairwise(late)]
        assert 4.0 / POSTPONED_S * 0.5 < sum(changes) <= 4.0 / POSTPONED_S + 2
        assert {answer.material for answer in late} <= {None, name}
        assert usual[-1].best == late[-1].best


@pytest.mark.long
def test_when_the_load_ends_all_readings_count(knowledge: ThermalKnowledge) -> None:
    (touch,) = made_touches(next(iter(MATERIALS)), 1, seed=710)
    usual, _ = course(knowledge, touch, 0.0)
    relieved, _ = course(knowledge, touch, 2.0)
    assert relieved[-1].best == usual[-1].best
    assert relieved[-1].object_c is not None
    assert usual[-1].object_c is not None
    assert abs(relieved[-1].object_c - usual[-1].object_c) < 0.2 * (usual[-1].object_c_sd or 0.0)
