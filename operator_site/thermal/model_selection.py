"""Which model of skin and object a touch needs: the smallest whose felt temperature is right enough.

Right enough is an error of T1 within max(0.1 K, a tenth of the change): the best cold threshold of the hand, and a
quarter of the step in heat flux that people tell apart. The model is linear, so its error grows with the difference in
temperature between object and skin, and each rung has a largest difference for each object and dwell: a table of those
is made with a model of 100 cells (`operator_site.thermal.model_error`). A half space enters by its effusivity and by
how it touches alone: cells are cut where heat has come to.
"""

import json
import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

from operator_site.thermal.skin_model import SkinModel, Touched
from operator_site.thermal.tissue import Floats

TOLERANCE_K = 0.1
TOLERANCE_SHARE = 0.1
"""Of the change of the felt temperature."""
USED = 0.9
"""A rung is used up to this part of the tolerance: the table is read between its points."""
RUNGS = (SkinModel(1, 1, 1), SkinModel(2, 1, 1, 6), SkinModel(4, 1, 1, 6), SkinModel(5, 5, 6, 10))
"""Small to large; a finger at rest has none."""
ANY_K = 1000.0
"""Stands for a difference without bound."""
TABLE = Path(__file__).parents[1] / "tables" / "rungs.json"
LONGEST_S = 10.0
"""How long a touch is taken to last where nobody knows: later the object's ladder ends."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A model, and why.

    Attributes:
        model: what to use.
        rung: its index in RUNGS.
        largest_k: up to which difference it is right enough, K; ANY_K where for any.
        enough: whether that covers the touch; the largest model is used beyond.
        why: in words.
    """

    model: SkinModel
    rung: int
    largest_k: float
    enough: bool
    why: str


@dataclass(frozen=True, slots=True)
class ModelTable:
    """Largest differences by rung, ln effusivity, ln contact resistance and dwell; the last rung included.

    Attributes:
        ln_effusivity: (e,) of J/(m2 K s^0.5).
        ln_contact: (r,) of m2K/W.
        dwell_s: (d,).
        ln_largest_k: (rungs, e, r, d) ln of K.
    """

    ln_effusivity: Floats
    ln_contact: Floats
    dwell_s: Floats
    ln_largest_k: Floats

    def largest_k(self, rung: int, touched: Touched, dwell_s: float) -> float:
        """Up to which difference a rung is right enough, K; beyond the table's edges as at them."""
        volume = touched.density_kg_m3 * touched.specific_heat_j_kgk
        ln_effusivity = 0.5 * math.log(touched.conductivity_w_mk * volume)
        longer = min(int(np.searchsorted(self.dwell_s, dwell_s - 1e-9)), len(self.dwell_s) - 1)
        table = self.ln_largest_k[rung, :, :, longer]
        i, u = _between(self.ln_effusivity.tolist(), ln_effusivity)
        j, v = _between(self.ln_contact.tolist(), math.log(touched.contact_m2k_w))
        corners = table[i : i + 2, j : j + 2]
        return math.exp(float(np.array([1.0 - u, u]) @ corners @ np.array([1.0 - v, v])))


def _between(knots: Sequence[float], value: float) -> tuple[int, float]:
    """Knot below a value, and how far it is to the next, 0..1."""
    at = min(max(bisect_left(knots, value) - 1, 0), len(knots) - 2)
    return at, min(max((value - knots[at]) / (knots[at + 1] - knots[at]), 0.0), 1.0)


@cache
def rung_table() -> ModelTable:
    """The table that ships with the program."""
    stored = json.loads(TABLE.read_text(encoding="utf-8"))
    if stored["rungs"] != [str(model) for model in RUNGS]:
        raise ValueError(f"{TABLE}: made for other models ({', '.join(stored['rungs'])}): run make rungs")
    axes = (np.array(stored[name]) for name in ("ln_effusivity", "ln_contact", "dwell_s"))
    ln_effusivity, ln_contact, dwell_s = axes
    return ModelTable(ln_effusivity, ln_contact, dwell_s, np.log(np.array(stored["largest_k"])))


@lru_cache(maxsize=256)
def _largest_k(rung: int, touched: Touched, dwell_s: float) -> float:
    """What the program's table says of a rung; a touch asks the same again in every step."""
    return rung_table().largest_k(rung, touched, dwell_s)


def choose(touched: Touched, difference_k: float, dwell_s: float = LONGEST_S) -> Choice:
    """The smallest model that is right enough.

    Args:
        touched: the object.
        difference_k: object minus skin's surface at contact, K.
        dwell_s: how long the touch may last, s.
    """
    wanted = abs(difference_k)
    largest = 0.0
    for rung, model in enumerate(RUNGS):
        largest = _largest_k(rung, touched, dwell_s)
        if wanted <= largest:
            up_to = "any difference" if largest >= 0.5 * ANY_K else f"up to {largest:.1f} K"
            return Choice(model, rung, largest, True, f"smallest that is right enough for {wanted:.1f} K ({up_to})")
    why = f"largest there is; right enough up to {largest:.1f} K, not for {wanted:.1f} K"
    return Choice(RUNGS[-1], len(RUNGS) - 1, largest, False, why)
