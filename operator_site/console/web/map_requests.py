"""Answers the requests of pages that read the map at a place."""

from typing import Any

from common.files.constants import within
from common.link.session_state import Refused
from operator_site.console import texts
from operator_site.console.examination.contrast import propose
from operator_site.console.examination.findings import MEASURED, compare, value_text
from operator_site.console.examination.tender_finding import propose_tender
from operator_site.console.map.tactile_map import TactileMap
from operator_site.console.tenderness.tender_search import Tenderness
from operator_site.console.web.answer import Answer

_FARTHEST_MM = 1e6
"""Largest coordinate of a place, mm."""


def values_at(surface: TactileMap, quantity: str, details: dict[str, Any], now_s: float) -> Answer:
    """Answer with the identified properties at a place; the text has one quantity, this one where it is known.

    Raises:
        Refused: the details have no place.
    """
    x_m, y_m = _place_m(details)
    scale = surface.roughness_um
    here = surface.at(x_m, y_m)
    measured = {name: value for name in MEASURED if (value := getattr(here, name)) is not None}
    shown: dict[str, Any] = {name: value_text(name, value, scale) for name, value in measured.items()}
    if here.lump is not None and "stiffness" in shown:
        shown["stiffness"] = texts.with_lump(shown["stiffness"], here.lump)
    if here.material is not None:
        shown["material"] = f"{texts.named(here.material[0])} {texts.percent(here.material[1])}"
    name = quantity if quantity in measured else next(iter(measured), None)
    text = texts.NOTHING_HERE
    if quantity == "material" and quantity in shown:
        text = shown[quantity]
    elif name is not None:
        value = measured[name]
        differs = compare(name, here, surface.around(x_m, y_m), scale)
        text = texts.place(shown[name], value.touches, max(0.0, now_s - value.last_s), differs)
    return Answer(True, text, {"text": text, **shown})


def propose_kind(surface: TactileMap, details: dict[str, Any], tenderness: Tenderness | None = None) -> Answer:
    """Answer with the kind that the contrast at a place proposes, see `propose`; with tenderness, also that kind.

    Raises:
        Refused: the details have no place.
    """
    x_m, y_m = _place_m(details)
    proposed = propose(surface.at(x_m, y_m), surface.around(x_m, y_m), surface.roughness_um)
    return Answer(True, "", proposed if tenderness is None else propose_tender(proposed, tenderness, x_m, y_m))


def _place_m(details: dict[str, Any]) -> tuple[float, float]:
    """Return the place of a request, m.

    Raises:
        Refused: it has none.
    """
    x_mm, y_mm = details.get("x_mm"), details.get("y_mm")
    if not (within(x_mm, -_FARTHEST_MM, _FARTHEST_MM) and within(y_mm, -_FARTHEST_MM, _FARTHEST_MM)):
        raise Refused(texts.PLACE_NEEDED)
    return x_mm / 1000.0, y_mm / 1000.0
