"""Contrast of a finding with its surroundings: proposes the kind before it is saved, and gives the confidence in it."""

import math
from typing import Any, NamedTuple

from common.wire.roughness_um import RoughnessUm
from operator_site.console.examination.findings import (
    CLEAR,
    LEAST,
    QUANTITY,
    compare,
    difference,
    likely_kind,
    signed,
    with_sd,
)
from operator_site.console.map.tactile_map import ExploredPlace
from operator_site.console.texts import ALSO_NOT_COMPARED, NO_DIFFERENCE, NOT_COMPARED, NOTHING_COMPARED

CONFIDENCES = ("none", "low", "fair", "high")
"""Confidence that a place differs as its kind says: none without a contrast, low without a clear one."""
SURE = 5.0
"""Smallest difference of a high confidence, in standard deviations of the difference."""
_LESS = frozenset(("cold", "soft"))
"""Kinds of a smaller value than around."""


class Contrast(NamedTuple):
    """Contrast of a place with its surroundings in one quantity: a difference in K, or a ratio.

    `clear` says whether the place differs clearly in the direction of the kind. `confidence` is one of CONFIDENCES.
    """

    quantity: str
    value: float
    sd: float
    clear: bool
    confidence: str

    def text(self) -> str:
        """Return the contrast with its standard deviation, such as `1.8 ± 0.1 times` or `+2.1 ± 0.4 K`."""
        if self.quantity == "temperature":
            return f"{signed(self.value, self.sd)} K"
        return f"{with_sd(self.value, self.sd)} times"

    def record(self) -> dict[str, Any]:
        """Return the contrast as part of a record."""
        return {name: getattr(self, name) for name in ("quantity", "value", "sd", "clear")}


def contrast_of(kind: str | None, here: ExploredPlace, around: ExploredPlace) -> Contrast | None:
    """Return the contrast of a place in the quantity of a kind; None if it is unknown."""
    quantity = QUANTITY.get(kind or "")
    mine, theirs = (getattr(place, quantity) if quantity else None for place in (here, around))
    if quantity is None or mine is None or theirs is None:
        return None
    differs = difference(quantity, mine, theirs)
    as_said = -differs.value if kind in _LESS else differs.value
    clear = as_said >= LEAST[quantity] and differs.clear >= CLEAR
    confidence = "low" if not clear else "high" if differs.clear >= SURE else "fair"
    if quantity == "temperature":
        return Contrast(quantity, differs.value, differs.sd, clear, confidence)
    ratio = math.exp(differs.value)
    return Contrast(quantity, ratio, ratio * differs.sd, clear, confidence)


def contrast_text(record: dict[str, Any] | None) -> str:
    """Return a recorded contrast in a few words, such as `+2.1 ± 0.4 K`; empty if it is unknown or unreadable."""
    try:
        found = Contrast(record["quantity"], float(record["value"]), float(record["sd"]), True, "") if record else None
    except (KeyError, TypeError, ValueError):
        return ""
    return "" if found is None else found.text()


def compared(kind: str | None, here: ExploredPlace, around: ExploredPlace, scale: RoughnessUm | None = None) -> str:
    """Describe the contrast of a finding in words, also that there is no clear one; empty if it is unknown."""
    found = contrast_of(kind, here, around)
    if found is None or found.clear:
        return compare(QUANTITY.get(kind or ""), here, around, scale)
    return f"{NO_DIFFERENCE if _same(found) else f'not {kind}er than its surroundings'} ({found.text()})"


def _same(found: Contrast) -> bool:
    """Return whether a contrast is too small or too uncertain for any kind."""
    size = abs(found.value) if found.quantity == "temperature" else abs(math.log(found.value))
    sd = found.sd if found.quantity == "temperature" else found.sd / found.value
    return size < LEAST[found.quantity] or size < CLEAR * sd


def propose(here: ExploredPlace, around: ExploredPlace, scale: RoughnessUm | None) -> dict[str, Any]:
    """Return what to show before a finding is saved: the proposed kind, and the contrast of each kind in words.

    A roughness is in um where its `scale` holds, else a level of 10, as in the finding. `text` is for a place without a
    proposed kind: the contrasts of all measured quantities.
    """
    kinds = {}
    for kind, quantity in QUANTITY.items():
        found = contrast_of(kind, here, around)
        kinds[kind] = {
            "text": compared(kind, here, around, scale) or NOT_COMPARED.format(quantity=quantity),
            "confidence": "none" if found is None else found.confidence,
        }
    every = {quantity: contrast_of(kind, here, around) for kind, quantity in QUANTITY.items() if kind not in _LESS}
    measured = [f"{quantity} {found.text()}" for quantity, found in every.items() if found is not None]
    unknown = [quantity for quantity, found in every.items() if found is None]
    text = f"{NO_DIFFERENCE} ({', '.join(measured)})" if measured else NOTHING_COMPARED
    if measured and unknown:
        text += ALSO_NOT_COMPARED.format(quantities=", ".join(unknown))
    return {"kind": likely_kind(here, around), "kinds": kinds, "text": text}
