"""The study of other objects: a run of tiny sizes."""

from pathlib import Path

import pytest

from studies.other_objects.figure import plot
from studies.other_objects.run import CALIBRATIONS, OBJECTS, Sizes, measure
from studies.second_world.worlds import FINGERS, World, calibration_hands
from tests.unit.studies.written import draw_figure


@pytest.mark.long
def test_a_tiny_run_has_all_calibrations_and_objects(tmp_path: Path) -> None:
    progress: list[float] = []
    data = measure(Sizes(1, 10, 1, (0.5, 1.0)), 0, progress.append)
    assert progress == sorted(progress)
    rows = data["shares"]
    assert len(rows) == 2 * len(CALIBRATIONS) * len(OBJECTS) * len(FINGERS) * 2
    assert {row["touches"] for row in rows} == {4}
    assert {row["calibration"] for row in rows} == set(CALIBRATIONS)
    assert {row["objects"] for row in rows} == {objects.name for objects in OBJECTS}
    draw_figure(plot, data, tmp_path, 50_000)


@pytest.mark.long
@pytest.mark.parametrize("world", ["A", "B"])
def test_later_calibration_touches_are_the_same_without_the_earlier_ones(world: World) -> None:
    every = calibration_hands(world, 3, "pvc", 10, 0.5)
    later = calibration_hands(world, 3, "pvc", 5, 0.5, first=5)
    assert len(later) == 5
    assert {hand.object_c for hand in later} <= {hand.object_c for hand in every}
