"""The predicted accuracy comes from touches that have not taught the discrepancy."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from remote_site.thermal.calibration import expected_accuracy
from remote_site.thermal.calibration.discrepancy_fit import Seen, learn
from remote_site.thermal.calibration.expected_accuracy import FOLDS, TIMES_S, Judged, judge_in_folds
from remote_site.thermal.calibration.thermal_calibration import ThermalFit
from remote_site.thermal.discrepancy import Discrepancy
from remote_site.thermal.material_table import MaterialTable

pytestmark = pytest.mark.long

AT_S = (TIMES_S[0], TIMES_S[-1])


@pytest.fixture(scope="module")
def seen(thermal_fit: tuple[ThermalFit, Path]) -> dict[float, list[Seen]]:
    """What was seen at two of the times."""
    return {t_s: thermal_fit[0].seen[t_s] for t_s in AT_S}


@pytest.fixture(scope="module")
def judged_and_taught(
    thermal_fit: tuple[ThermalFit, Path], seen: dict[float, list[Seen]]
) -> tuple[list[Judged], list[set[int]]]:
    """Judged touches, and the numbers of the touches that taught each fold."""
    taught: list[set[int]] = []

    def learned(table: MaterialTable, seen: dict[float, list[Seen]]) -> Discrepancy:
        taught.append({one.number for each in seen.values() for one in each})
        assert {frozenset(one.number for one in each) for each in seen.values()} == {frozenset(taught[-1])}
        return learn(table, seen)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(expected_accuracy, "learn", learned)
        return judge_in_folds(thermal_fit[0].before, seen), taught


def test_each_touch_is_judged_once_and_pairs_are_more_certain(
    judged_and_taught: tuple[list[Judged], list[set[int]]], seen: dict[float, list[Seen]]
) -> None:
    judged = judged_and_taught[0]
    one, two = ([each for each in judged if each.fingers == fingers] for fingers in (1, 2))
    count = Counter(each.t_s for each in one)
    assert count == {t_s: len(seen[t_s]) for t_s in AT_S}
    for t_s in AT_S:
        sds = [np.median([each.sd_k for each in judged if each.t_s == t_s]) for judged in (one, two)]
        assert sds[1] < sds[0]
    late = [each for each in one if each.t_s == AT_S[-1]]
    assert np.mean([each.right for each in late]) > 0.9
    assert np.median([abs(each.error_k or 0.0) for each in late]) < 0.3


def test_no_touch_is_judged_by_what_it_taught(
    judged_and_taught: tuple[list[Judged], list[set[int]]], seen: dict[float, list[Seen]]
) -> None:
    taught = judged_and_taught[1]
    everyone = {one.number for one in seen[AT_S[0]]}
    left_out = [number for each in taught for number in everyone - each]
    assert len(taught) == FOLDS
    assert sorted(left_out) == sorted(everyone)


def test_touches_without_object_temperature_give_no_error_and_no_pair(thermal_fit: tuple[ThermalFit, Path]) -> None:
    seen = {1.0: [Seen(one.evidence, one.material, None, one.number) for one in thermal_fit[0].seen[1.0]]}
    found = judge_in_folds(thermal_fit[0].before, seen)
    assert {(one.fingers, one.error_k) for one in found} == {(1, None)}
