"""The walks on the page name modules and types that exist, count them correctly, and do not grow."""

import re

import pytest

from tests.places import ROOT

MOST = {
    "A motion of the operator's finger": (20, 8),
    "A groove under the remote finger": (30, 11),  # goal: 30 and 8
    "One reading of a thermal sensor": (35, 18),  # goal: 25 and 8
}
"""Largest numbers of files and of changes of form: what the code has. Lower them when a walk becomes shorter."""

_PAGE = (ROOT / "docs" / "how-it-works" / "walks.md").read_text("utf-8")
_WALKS = dict(part.split("\n", 1) for part in _PAGE.split("\n## ")[1:])
_STATION = re.compile(r"(?m)^(\d+)\. `([\w/]+\.py)`(.*(?:\n +.*)*)$")


def stations(walk: str) -> list[tuple[str, str, str]]:
    """Number, module and the rest of the text of each station."""
    return _STATION.findall(_WALKS[walk])


def test_the_page_has_these_walks() -> None:
    assert list(_WALKS) == list(MOST)


def test_each_module_exists() -> None:
    modules = re.findall(r"`([\w/]+\.py)`", _PAGE)
    assert modules
    assert [path for path in modules if not (ROOT / path).is_file()] == []


@pytest.mark.parametrize("walk", MOST)
def test_counts_are_those_of_the_list_and_do_not_grow(walk: str) -> None:
    found = stations(walk)
    assert [int(number) for number, _, _ in found] == list(range(1, len(found) + 1))
    files, forms = len({path for _, path, _ in found}), sum(text.count("→") for _, _, text in found)
    assert f"\n**{files} files, {forms} changes of form.**\n" in _WALKS[walk]
    most_files, most_forms = MOST[walk]
    assert files <= most_files
    assert forms <= most_forms


@pytest.mark.parametrize("walk", MOST)
def test_each_type_is_defined_at_a_station(walk: str) -> None:
    found = stations(walk)
    code = "\n".join((ROOT / path).read_text("utf-8") for _, path, _ in found)
    types = [name for _, _, text in found for name in re.findall(r"→ `(\w+)`", text)]
    assert types
    assert [name for name in types if not re.search(rf"(?m)^(class {name}\b|{name} = )", code)] == []
