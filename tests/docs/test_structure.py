"""The layout keeps its limits, and its page is up to date."""

import pytest

from tests.places import ROOT
from tests.structure import MOST_FILES, MOST_FLOORS, ROOMS, Room, measure, opaque_names, page


@pytest.fixture(scope="module")
def rooms() -> dict[str, Room]:
    return measure()


@pytest.mark.parametrize("name", ROOMS)
def test_no_folder_is_crowded(name: str, rooms: dict[str, Room]) -> None:
    assert {folder: count for folder, count in rooms[name].folders.items() if count > MOST_FILES} == {}


@pytest.mark.parametrize("name", ROOMS)
def test_imports_inside_a_room_go_down_a_few_floors(name: str, rooms: dict[str, Room]) -> None:
    assert 0 < rooms[name].floors <= MOST_FLOORS


def test_import_cycles_are_found() -> None:
    with pytest.raises(ValueError, match="imports go round: a -> b -> a"):
        _ = Room({}, (), {"a": frozenset("b"), "b": frozenset("a")}).floors


def test_module_names_are_descriptive() -> None:
    assert opaque_names() == []


def test_every_folder_states_its_contents() -> None:
    short = []
    for room in ROOMS:
        for path in (ROOT / room).rglob("*.py"):
            init = path.with_name("__init__.py")
            if not init.exists() or not init.read_text("utf-8").startswith('"""'):
                short.append(str(path.parent))
    assert short == []


def test_the_page_is_up_to_date() -> None:
    assert (ROOT / "docs" / "structure.md").read_text("utf-8") == page(), (
        "python -m tests.structure > docs/structure.md"
    )
