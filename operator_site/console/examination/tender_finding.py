"""Describes a tender place as a finding, and proposes it before it is saved."""

import math
from typing import Any

from operator_site.console import texts
from operator_site.console.examination.contrast import CONFIDENCES
from operator_site.console.examination.findings import TENDER
from operator_site.console.tenderness.tender_search import CIRCLE_SD, Tenderness

SURE = 0.95
"""Least probability of one tender place at a high confidence."""
_NONE, _LOW, _FAIR, _HIGH = CONFIDENCES


def is_most_tender(tenderness: Tenderness, x_m: float, y_m: float) -> bool:
    """Return whether a place lies in the circle that holds the most tender place with a probability of 95 %."""
    place = tenderness.known_place
    return place is not None and math.dist((x_m, y_m), (place.x_m, place.y_m)) <= CIRCLE_SD * place.sd_m


def tender_text(tenderness: Tenderness, x_m: float, y_m: float) -> tuple[str, str]:
    """Return what is known of a place's tenderness, in words, and the confidence in it, one of CONFIDENCES."""
    place = tenderness.known_place
    said = texts.most_tender(tenderness.place_mm, tenderness.known_threshold_n, alike=tenderness.alike)
    if place is None:
        return said, _NONE
    if not is_most_tender(tenderness, x_m, y_m):
        return texts.TENDER_NOT_HERE.format(most_tender=said), _LOW
    if tenderness.alike:
        return said, _LOW
    return said, _HIGH if place.probability >= SURE else _FAIR


def propose_tender(proposed: dict[str, Any], tenderness: Tenderness, x_m: float, y_m: float) -> dict[str, Any]:
    """Return a proposal, see `contrast.propose`, with the kind of a tender place, also as the proposed one."""
    text, confidence = tender_text(tenderness, x_m, y_m)
    kind = TENDER if is_most_tender(tenderness, x_m, y_m) else proposed["kind"]
    kinds = proposed["kinds"] | {TENDER: {"text": text, "confidence": confidence}}
    return proposed | {"kind": kind, "kinds": kinds}
