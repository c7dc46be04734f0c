"""Late ticks postpone the solutions of a touch, for a while; nothing is lost by it, and nothing is named wrongly."""

from itertools import pairwise

from remote_site.late_ticks import LATE, POSTPONED_S, LateTicks
from remote_site.thermal_answer import ThermalAnswer
from remote_site.thermal_identification import ThermalIdentification, ThermalKnowledge
from tests.remote_site.made_touches import AMBIENT_C, MATERIALS, MadeTouch, made_touches

PERIOD_S = 0.002


def course(knowledge: ThermalKnowledge, touch: MadeTouch, late_until_s: float) -> tuple[list[ThermalAnswer], int]:
    """Answers to each reading, and at how many of them a solution waited."""
    identification = ThermalIdentification(knowledge)
    identification.start(0.0, touch.start_c, 0.0, AMBIENT_C)
    answers = [identification.step(*row, row[0] < late_until_s) for row in touch.until(4.0).after()]
    return answers, identification.postponed


def test_a_tick_is_late_by_half_a_period() -> None:
    late = LateTicks(PERIOD_S)
    times_s = [5.0, 5.002, 5.004, 5.004 + 1.1 * LATE * PERIOD_S, 5.010, 1.0, 1.002]
    assert [late.step(t_s) for t_s in times_s] == [False, False, False, True, False, False, False]


def test_where_every_tick_is_late_answers_come_later_and_none_is_wrong(calibrated_knowledge: ThermalKnowledge) -> None:
    for seed, name in enumerate(MATERIALS):
        (touch,) = made_touches(name, 1, seed=700 + seed)
        usual, postponed = course(calibrated_knowledge, touch, 0.0)
        assert postponed == 0
        late, postponed = course(calibrated_knowledge, touch, 10.0)
        assert postponed > 100
        changes = [now is not before for before, now in pairwise(late)]
        assert 4.0 / POSTPONED_S * 0.5 < sum(changes) <= 4.0 / POSTPONED_S + 2
        assert {answer.material for answer in late} <= {None, name}
        assert usual[-1].best == late[-1].best


def test_when_the_load_ends_all_readings_count(calibrated_knowledge: ThermalKnowledge) -> None:
    (touch,) = made_touches(next(iter(MATERIALS)), 1, seed=710)
    usual, _ = course(calibrated_knowledge, touch, 0.0)
    relieved, _ = course(calibrated_knowledge, touch, 2.0)
    assert relieved[-1].best == usual[-1].best
    assert relieved[-1].object_c is not None
    assert usual[-1].object_c is not None
    assert abs(relieved[-1].object_c - usual[-1].object_c) < 0.2 * (usual[-1].object_c_sd or 0.0)
