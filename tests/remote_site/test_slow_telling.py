"""What is told for a person to read changes slowly, and is of what is being touched."""

import itertools
from pathlib import Path

import pytest

from common.packets import LinkState
from common.told import NOTHING, TOLD_EVERY_S, Told
from remote_site.material_table import MaterialTable
from remote_site.perception import Perception
from remote_site.sensed import Sensed
from remote_site.surface_class import SurfaceTable
from teletaction.recorded_session import RecordedSession

SESSION = Path(__file__).parents[1] / "golden" / "session.mcap"
TABLES = Path(__file__).parents[2] / "remote_site" / "tables"
INDEX = 1


@pytest.fixture(scope="module")
def ticks() -> list[tuple[float, bool, tuple[Told, ...]]]:
    """Time of each tick of a recorded session, s, whether the index finger touched, and what was told."""
    perception = Perception(
        ["thumb", "index"], MaterialTable.load(TABLES / "materials.json"), SurfaceTable.load(TABLES / "surfaces.json")
    )
    found = []
    with SESSION.open("rb") as file:
        for number, (_, _, _, data) in enumerate(RecordedSession(SESSION, file).messages(("remote/sensed",))):
            sensed = Sensed.unpack(data)
            perception.step(sensed)
            perception.work()
            told = perception.packet(1, number, number, LinkState.ENGAGED).told
            found.append((sensed.time_s, perception.touches[INDEX].contact, told))
    return found


def test_it_changes_ten_times_a_second_at_most_and_is_the_same_object_between(
    ticks: list[tuple[float, bool, tuple[Told, ...]]],
) -> None:
    changes_s = [t_s for (_, _, before), (t_s, _, told) in itertools.pairwise(ticks) if told is not before]
    assert len(changes_s) > 20
    assert min(later - earlier for earlier, later in itertools.pairwise(changes_s)) >= TOLD_EVERY_S - 1e-9


def test_the_likeliest_comes_first_and_no_more_than_all_is_told(
    ticks: list[tuple[float, bool, tuple[Told, ...]]],
) -> None:
    told = {told[INDEX] for _, contact, told in ticks if told[INDEX].candidates}
    assert len({len(one.candidates) for one in told}) > 1
    for one in told:
        probabilities = [probability for _, probability in one.candidates]
        assert probabilities == sorted(probabilities, reverse=True)
        assert sum(probabilities) <= 1.0 + 1e-6


def test_nothing_is_told_of_a_finger_that_is_free(ticks: list[tuple[float, bool, tuple[Told, ...]]]) -> None:
    touched_s = -1.0
    for t_s, contact, told in ticks:
        touched_s = t_s if contact else touched_s
        if t_s - touched_s > TOLD_EVERY_S:
            assert told[INDEX] == NOTHING
        assert told[2] == NOTHING, "a finger that is not in use"


def test_roughness_is_told_with_what_is_not_yet_known_of_it(ticks: list[tuple[float, bool, tuple[Told, ...]]]) -> None:
    rough = [told[INDEX] for _, _, told in ticks if told[INDEX].roughness_v is not None]
    assert rough
    for told in rough:
        assert told.roughness_sd_v is not None
        assert 0.0 < told.roughness_sd_v < 0.5 * (told.roughness_v or 0.0)
