"""Names a place on the body: a region of the body diagram, its side, and the distance from a landmark.

The diagram is `page/body.svg`. Its shapes have the attributes `data-r` for the region and `data-s` for the
side.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib import resources
from typing import Any
from xml.etree import ElementTree

from common.files.constants import within
from common.link.session_state import Refused
from operator_site.console import texts

VIEWS = ("head", "front", "back", "hand")
"""Views of the diagram; each is a group of its id in the picture."""
BODY_SIDES = ("", "left", "right", "both")
"""Sides of a region from the examined person's view; empty for the middle or for none given."""
LONGEST_LANDMARK = 80
"""Maximum length of a landmark, characters."""
FARTHEST_MM = 1000.0
"""Largest distance from a landmark, mm."""
_PICTURE = resources.files("operator_site") / "console" / "page" / "body.svg"
_SVG = "http://www.w3.org/2000/svg"
_MARKED = {"fill": "#10151B", "fill-opacity": "0.65"}
_PLAIN = {"fill": "none", "stroke": "#10151B", "stroke-width": "1"}


@dataclass(frozen=True, slots=True)
class BodyMark:
    """A place on the body: region, side, landmark, and the distance from it, mm; None if not given."""

    region: str
    side: str = ""
    landmark: str = ""
    landmark_mm: float | None = None

    def record(self) -> dict[str, Any]:
        """Return the mark as part of a record."""
        return asdict(self)

    def text(self) -> str:
        """Return the mark in words, such as `left forearm, 20 mm from the wrist crease`."""
        words = f"{self.side} {self.region}".strip()
        if not self.landmark:
            return words
        far = "at" if self.landmark_mm is None else f"{self.landmark_mm:g} mm from"
        return f"{words}, {far} {self.landmark}"


def body_mark(record: Mapping[str, Any]) -> BodyMark | None:
    """Return the place of a recorded finding or of a recorded begin of an examination; None without a valid one."""
    try:
        return read_mark(record.get("body"))
    except Refused:
        return None


def read_mark(given: object) -> BodyMark | None:
    """Return a place from its fields; None if none is given.

    Raises:
        Refused: a field is not valid.
    """
    if given is None:
        return None
    fields = given if isinstance(given, dict) else {}
    region, side, landmark = (fields.get(name) or "" for name in ("region", "side", "landmark"))
    landmark_mm = fields.get("landmark_mm")
    if not isinstance(region, str) or region not in regions() or side not in BODY_SIDES:
        raise Refused(texts.BODY_NEEDS)
    if not isinstance(landmark, str) or len(landmark) > LONGEST_LANDMARK or not landmark.isprintable():
        raise Refused(texts.LANDMARK_LENGTH.format(longest=LONGEST_LANDMARK))
    if landmark_mm is not None and not within(landmark_mm, 0.0, FARTHEST_MM):
        raise Refused(texts.LANDMARK_DISTANCE.format(farthest=FARTHEST_MM))
    return BodyMark(region, side, landmark.strip(), landmark_mm)


@cache
def regions() -> dict[str, str]:
    """Return the view of each region of the diagram."""
    return {
        str(shape.get("data-r")): str(view.get("id"))
        for view in _picture().iter(f"{{{_SVG}}}g")
        if view.get("id") in VIEWS
        for shape in view.iter()
        if shape.get("data-r")
    }


def body_svg(mark: BodyMark) -> str:
    """Return the view of the diagram with the marked region filled, as an SVG element for a page."""
    picture, name = _picture(), regions()[mark.region]
    for view in [group for group in picture if group.get("id") in VIEWS]:
        if view.get("id") != name:
            picture.remove(view)
        view.attrib.pop("transform", None)
    for shape in picture.iter():
        region, side = shape.attrib.pop("data-r", None), shape.attrib.pop("data-s", "")
        marked = region == mark.region and (not side or mark.side in ("", "both", side))
        shape.attrib.update(_PLAIN | _MARKED if marked else _PLAIN)
    picture.attrib.update({"viewBox": "0 0 100 200", "role": "img", "aria-label": mark.text()})
    ElementTree.register_namespace("", _SVG)
    return ElementTree.tostring(picture, encoding="unicode")


def _picture() -> ElementTree.Element:
    return ElementTree.fromstring(_PICTURE.read_text("utf-8"))
