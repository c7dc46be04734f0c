"""Selects the smallest model of skin and object whose felt temperature is accurate enough for a touch.

The error of T1 may be max(0.1 K, a tenth of the change). These are the best cold threshold of the hand, and a quarter
of the JND in heat flux. The model is linear, so its error grows with the temperature difference between object and
skin. Each candidate model therefore has a largest difference for each object and dwell. The table of these differences
is made with a model of 100 cells (`operator_site.thermal.model_error`). A half space enters only by its effusivity and
its contact resistance, because the cells scale with the depth that heat has reached.
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
"""Absolute tolerance of the felt temperature, K."""
TOLERANCE_SHARE = 0.1
"""Relative tolerance of the change of the felt temperature."""
USED = 0.9
"""Used share of the tolerance; the rest is for interpolation in the table."""
RUNGS = (SkinModel(1, 1, 1), SkinModel(2, 1, 1, 6), SkinModel(4, 1, 1, 6), SkinModel(5, 5, 6, 10))
"""Candidate models from small to large; a finger at rest has none."""
ANY_K = 1000.0
"""Largest difference that stands for an unlimited one, K."""
TABLE = Path(__file__).parents[1] / "tables" / "rungs.json"
LONGEST_S = 10.0
"""Assumed dwell of a touch without another estimate, s; the object's cells reach no deeper than heat in this time."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A selected model and the reason.

    Attributes:
        model: model to use.
        rung: index of the model in RUNGS.
        largest_k: largest difference at which the model is accurate enough, K; ANY_K if unlimited.
        enough: whether this covers the touch; if no model does, the largest one is selected.
        why: reason in words.
    """

    model: SkinModel
    rung: int
    largest_k: float
    enough: bool
    why: str


@dataclass(frozen=True, slots=True)
class ModelTable:
    """Largest differences by candidate model, ln effusivity, ln contact resistance and dwell.

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
        """Return the largest difference at which a model is accurate enough, K; clamped at the table's edges."""
        volume = touched.density_kg_m3 * touched.specific_heat_j_kgk
        ln_effusivity = 0.5 * math.log(touched.conductivity_w_mk * volume)
        longer = min(int(np.searchsorted(self.dwell_s, dwell_s - 1e-9)), len(self.dwell_s) - 1)
        table = self.ln_largest_k[rung, :, :, longer]
        i, u = _between(self.ln_effusivity.tolist(), ln_effusivity)
        j, v = _between(self.ln_contact.tolist(), math.log(touched.contact_m2k_w))
        corners = table[i : i + 2, j : j + 2]
        return math.exp(float(np.array([1.0 - u, u]) @ corners @ np.array([1.0 - v, v])))


def _between(knots: Sequence[float], value: float) -> tuple[int, float]:
    """Return the index of the knot below a value, and the value's share of the way to the next knot, 0..1."""
    at = min(max(bisect_left(knots, value) - 1, 0), len(knots) - 2)
    return at, min(max((value - knots[at]) / (knots[at + 1] - knots[at]), 0.0), 1.0)


@cache
def rung_table() -> ModelTable:
    """Return the shipped table; raise ValueError if it was made for other models."""
    stored = json.loads(TABLE.read_text(encoding="utf-8"))
    if stored["rungs"] != [str(model) for model in RUNGS]:
        raise ValueError(f"{TABLE}: made for other models ({', '.join(stored['rungs'])}): run make rungs")
    axes = (np.array(stored[name]) for name in ("ln_effusivity", "ln_contact", "dwell_s"))
    ln_effusivity, ln_contact, dwell_s = axes
    return ModelTable(ln_effusivity, ln_contact, dwell_s, np.log(np.array(stored["largest_k"])))


@lru_cache(maxsize=256)
def _largest_k(rung: int, touched: Touched, dwell_s: float) -> float:
    """Return the shipped table's largest difference, K; cached, because a touch needs it again in every step."""
    return rung_table().largest_k(rung, touched, dwell_s)


def choose(touched: Touched, difference_k: float, dwell_s: float = LONGEST_S) -> Choice:
    """Select the smallest model that is accurate enough for an expected dwell, s.

    `difference_k` is the object minus the skin's surface at contact, K.
    """
    wanted = abs(difference_k)
    largest = 0.0
    for rung, model in enumerate(RUNGS):
        largest = _largest_k(rung, touched, dwell_s)
        if wanted <= largest:
            up_to = "any difference" if largest >= 0.5 * ANY_K else f"up to {largest:.1f} K"
            return Choice(model, rung, largest, True, f"smallest model accurate enough for {wanted:.1f} K ({up_to})")
    why = f"largest model; accurate enough up to {largest:.1f} K, not for {wanted:.1f} K"
    return Choice(RUNGS[-1], len(RUNGS) - 1, largest, False, why)
