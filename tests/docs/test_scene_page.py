"""The page of virtual environments lists every field of a scene's object, and every act of a script."""

import re
from typing import get_args

from common.scenes.scene import SceneObject
from common.scenes.script import Step
from tests.places import ROOT

PAGE = (ROOT / "docs" / "howto" / "virtual.md").read_text("utf-8")


def rows(head: str) -> list[list[str]]:
    """Cells of the rows of the table with this head."""
    lines = PAGE.partition(f"| {head} |")[2].partition("\n\n")[0].splitlines()[2:]
    return [line.strip("| ").split("|") for line in lines]


def names(cell: str) -> set[str]:
    """Names of fields in a cell."""
    return set(re.findall(r"`(\w+)`", cell))


def test_every_field_of_an_object_is_listed() -> None:
    listed = set().union(*(names(cells[0]) for cells in rows("field of an object | meaning | default")))
    assert listed == SceneObject.model_fields.keys()


def test_every_act_is_listed_with_its_fields() -> None:
    listed = {cells[0].strip(" `"): names(cells[1]) for cells in rows("act | fields | does")}
    acts = get_args(get_args(Step)[0])
    found = {get_args(act.model_fields["act"].annotation)[0]: act.model_fields.keys() - {"act"} for act in acts}
    assert listed == found
