"""The study of both worlds: touches that differ where they must, and a run of tiny sizes."""

from pathlib import Path

import numpy as np
import pytest

from studies.second_world.figure import plot, reference_of
from studies.second_world.run import Set, Sizes, measure
from studies.second_world.worlds import FINGERS, UNITS, World, calibration_hands, judged_hands, learning_hands
from studies.thermal_identification.situations import Hand
from tests.unit.studies.written import draw_figure


def read_c(hand: Hand) -> list[float]:
    """Return the last reading of each finger, C."""
    return [float(finger.trace.sensor_c[-1]) for finger in hand.fingers]


@pytest.mark.long
@pytest.mark.parametrize("world", ["A", "B"])
def test_no_touch_is_used_twice(world: World) -> None:
    hands = [
        *calibration_hands(world, 3, "pvc", UNITS, 0.5),
        *(hand for turn in range(UNITS) for hand in learning_hands(world, 3, "pvc", turn, 1, 0.5)),
        *judged_hands(world, 3, "pvc", range(2), 0.5),
        *judged_hands(world, 3, "pvc", range(2, 4), 0.5),
    ]
    assert [len(hand.fingers) for hand in hands] == [1] * UNITS + [UNITS] * (UNITS + 4)
    assert len({hand.object_c for hand in hands}) == len(hands)
    assert len({reading for hand in hands for reading in read_c(hand)}) > len(hands)


@pytest.mark.parametrize("world", ["A", "B"])
def test_kinds_of_sensors_touch_different_pieces(world: World) -> None:
    pieces_c = {judged_hands(world, kind, "pvc", range(1), 0.1)[0].object_c for kind in range(3)}
    assert len(pieces_c) == 3


@pytest.mark.long
def test_worlds_differ() -> None:
    one, other = (judged_hands(world, 3, "pvc", range(1), 0.5)[0] for world in ("A", "B"))
    assert not np.allclose(read_c(one), read_c(other), atol=1e-3)


@pytest.mark.long
def test_a_tiny_run_has_both_worlds_beside_their_references(tmp_path: Path) -> None:
    names = ("aluminium", "pvc")
    sizes = Sizes((Set("A", names, 1, 10, 40, 2), Set("B", names, 1, 10, 40, 2)), (0.5, 1.0))
    progress: list[float] = []
    data = measure(sizes, 0, progress.append)
    assert progress == sorted(progress)
    assert {row["method"] for row in data["accuracy"]} == {*FINGERS, *map(reference_of, FINGERS)}
    assert {(row["world"], row["touches"]) for row in data["accuracy"]} == {("A", 4), ("B", 4)}
    assert all(row["object_within_sd"] is not None for row in data["accuracy"])
    draw_figure(plot, data, tmp_path, 50_000)
