"""The ladder against a way of limited rate, on which a picture that is too large delays touch."""

from dataclasses import dataclass
from itertools import pairwise

import pytest

from common.wire.camera_messages import ASK_S
from remote_site.camera.picture_ladder import CALM_WINDOW_S, CLIMB_S, GROWN_S, RUNGS, STEP_S, PictureLadder

BIT_S = 400_000
CALM_S = 0.040


@dataclass
class Way:
    """A way whose packets wait longer, the more of its rate is used."""

    rate_bit_s: float
    calm_s: float = CALM_S

    def age_s(self, bit_s: float) -> float:
        used = min(bit_s / self.rate_bit_s, 0.99)
        return self.calm_s * (1.0 + 0.2 * used / (1.0 - used))


def follow(ladder: PictureLadder, way: Way, begin_s: float, seconds: float) -> list[int]:
    """Step the ladder over a way; return the rung after each step."""
    found = []
    for number in range(round(seconds / ASK_S)):
        age_s = way.age_s(BIT_S * ladder.rung.bits)
        ladder.step(begin_s + number * ASK_S, age_s, age_s)
        found.append(ladder.number)
    return found


def test_the_best_picture_stays_where_the_way_has_room() -> None:
    assert set(follow(PictureLadder(), Way(20e6), 0.0, 120.0)) == {0}


@pytest.mark.parametrize("rate_bit_s", [900e3, 500e3, 250e3])
def test_a_narrow_way_gets_a_smaller_picture_and_touch_its_calm_age(rate_bit_s: float) -> None:
    ladder = PictureLadder()
    follow(ladder, Way(20e6), 0.0, 5.0)
    narrow = Way(rate_bit_s)
    rungs = follow(ladder, narrow, 5.0, 60.0)
    at_work = rungs[round(6.0 / ASK_S) :]
    grown = [narrow.age_s(BIT_S * RUNGS[rung].bits) > 1.1 * CALM_S + 1e-9 for rung in at_work]
    assert max(at_work) > 0
    assert sum(grown) < 0.25 * len(grown), "it tries a better picture now and then"


def test_a_step_down_takes_at_least_a_second_each() -> None:
    ladder = PictureLadder()
    follow(ladder, Way(20e6), 0.0, 2.0)
    rungs = follow(ladder, Way(20e6, calm_s=3.0 * CALM_S), 2.0, STEP_S * 3)
    assert rungs[-1] in (2, 3)


def test_an_age_that_the_picture_does_not_cause_becomes_the_calm_one() -> None:
    """The network itself became slower: after the lowest rung has changed nothing, the picture returns."""
    ladder = PictureLadder()
    follow(ladder, Way(20e6), 0.0, 5.0)
    slower = Way(20e6, calm_s=3.0 * CALM_S)
    rungs = follow(ladder, slower, 5.0, 60.0)
    assert max(rungs) == len(RUNGS) - 1
    assert rungs[-1] == 0


def test_single_late_packets_change_nothing() -> None:
    ladder = PictureLadder()
    for number in range(600):
        late = number % 7 == 0
        ladder.step(number * ASK_S, CALM_S + (0.2 if late else 0.0), CALM_S)
    assert ladder.number == 0


def test_it_climbs_after_calm_and_waits_longer_when_that_was_too_early() -> None:
    ladder = PictureLadder()
    way = Way(500e3)
    follow(ladder, Way(20e6), 0.0, 3.0)
    rungs = follow(ladder, way, 3.0, CALM_WINDOW_S - 10.0)
    climbs = [number * ASK_S for number in range(1, len(rungs)) if rungs[number] < rungs[number - 1]]
    waits = [second - first for first, second in pairwise(climbs)]
    assert climbs[0] >= CLIMB_S
    assert all(later > earlier for earlier, later in pairwise(waits))


def test_without_ages_nothing_changes() -> None:
    ladder = PictureLadder()
    for number in range(100):
        ladder.step(number * ASK_S, 0.0, 0.0)
    assert ladder.number == 0


def test_growth_below_the_noise_of_the_clocks_does_not_count() -> None:
    ladder = PictureLadder()
    for number in range(100):
        ladder.step(number * ASK_S, 0.001 + (0.9 * GROWN_S if number > 50 else 0.0), 0.001)
    assert ladder.number == 0
