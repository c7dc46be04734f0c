"""The scores of maps: their definitions exactly, and the bars on the recorded presses.

The recordings are no part of the project. They are looked for where TELETACTION_DATA says, else beside the checkout.
"""

import numpy as np
import pytest

from studies.palpation.map_bars import Truth, auc, chosen_one_by_one, dice, judged_maps, mapped, read_palpated
from tests.places import DATA
from tests.presses import spring_presses

RECORDED = pytest.mark.skipif(
    not (DATA / "palpation" / "truth").is_dir(), reason=f"no recorded presses in {DATA / 'palpation'}"
)


def test_the_area_under_the_curve() -> None:
    lump = np.array([True, True, False, False])
    assert auc(np.array([4.0, 3.0, 2.0, 1.0]), lump) == 1.0
    assert auc(np.array([4.0, 1.0, 3.0, 2.0]), lump) == 0.5
    assert auc(np.ones(4), lump) == 0.5


def test_dice() -> None:
    lump = np.array([True, True, False, False])
    assert dice(np.array([True, False, True, False]), lump) == 0.5
    assert dice(lump, lump) == dice(~lump & lump, ~lump & lump) == 1.0


def test_presses_without_a_place_make_no_map() -> None:
    truth = Truth(np.zeros((1, 2)), np.array([True]))
    with pytest.raises(ValueError, match="no press with a place"):
        mapped(spring_presses(3), truth)


@RECORDED
@pytest.mark.long
def test_the_bars_of_the_map() -> None:
    rows = list(judged_maps(read_palpated(DATA / "palpation", "kidney_bar_t1"), 12))
    means = {
        (number, key): np.mean([row[key] for row in rows if row.get("presses") == number])
        for number in (30, 60, 120)
        for key in ("auc_value", "auc_lump", "dice")
    }
    assert means[30, "auc_lump"] >= 0.88  # 12 draws; 0.91 over 40
    assert means[60, "auc_lump"] >= 0.97
    assert means[120, "dice"] >= 0.80
    *_, whole, single = rows
    assert single["auc_value"] >= 0.985
    assert whole["called"] >= 0.85
    assert whole["called_false"] <= 0.01


@RECORDED
@pytest.mark.long
def test_chosen_presses_need_fewer_than_spread_ones() -> None:
    palpated = read_palpated(DATA / "palpation", "kidney_bar_t1")
    rows = [row for seed in range(3) for row in chosen_one_by_one(palpated, seed)]

    def mean(way: str, number: int) -> float:
        return float(np.mean([row["auc_lump"] for row in rows if (row["way"], row["presses"]) == (way, number)]))

    assert mean("next_press", 45) >= mean("spread", 60)
    assert mean("next_press", 45) > mean("random", 60)
