"""Places on the body: the picture, its words, and the records that have or lack one."""

from typing import Any
from xml.etree import ElementTree

import pytest

from operator_site.console.examination.body import BODY_SIDES, VIEWS, BodyMark, body_mark, body_svg, regions

SIDED = {"ear", "cheek", "upper arm", "forearm", "thigh", "shin", "foot", "buttock", "back of the thigh", "calf"} | {
    region for region, view in regions().items() if view == "hand"
}


def test_each_view_has_regions() -> None:
    assert {*regions().values()} == {*VIEWS}


@pytest.mark.parametrize("region", regions())
@pytest.mark.parametrize("side", BODY_SIDES)
def test_a_marked_picture_is_one_view_with_the_region_filled(region: str, side: str) -> None:
    picture = ElementTree.fromstring(body_svg(BodyMark(region, side)))
    groups = [part for part in picture if part.tag.endswith("g")]
    assert [group.get("id") for group in groups] == [regions()[region]]
    filled = [shape for shape in groups[0] if shape.get("fill") != "none"]
    assert len(filled) == (2 if region in SIDED and side in ("", "both") else 1)
    assert picture.get("aria-label") == f"{side} {region}".strip()


@pytest.mark.parametrize(
    ("mark", "text"),
    [
        (BodyMark("chest"), "chest"),
        (BodyMark("forearm", "left", "wrist crease", 20.0), "left forearm, 20 mm from wrist crease"),
        (BodyMark("palm", "both", "the scar"), "both palm, at the scar"),
        (BodyMark("abdomen", "", "navel", 12.5), "abdomen, 12.5 mm from navel"),
    ],
)
def test_words(mark: BodyMark, text: str) -> None:
    assert mark.text() == text
    assert body_mark({"body": mark.record()}) == mark


@pytest.mark.parametrize(
    "record", [{}, {"body": None}, {"body": 3}, {"body": {"region": "tail"}}, {"body": {}}, {"body": {"region": [1]}}]
)
def test_records_without_a_valid_place(record: dict[str, Any]) -> None:
    assert body_mark(record) is None
