"""Computes the error of a model's felt temperature against a model of 100 cells; `model_selection` reads its table."""

import json
from pathlib import Path

import numpy as np

from operator_site.thermal.model_selection import ANY_K, LONGEST_S, RUNGS, TOLERANCE_K, TOLERANCE_SHARE, USED
from operator_site.thermal.skin_model import SkinModel, Touched, skin_rates
from operator_site.thermal.tissue import Floats

FINE = SkinModel(30, 15, 15, 40)
"""Reference model."""
TIMES_S = np.unique(np.round(np.geomspace(0.01, LONGEST_S, 90), 2))
DWELL_S = (0.5, 1.0, 2.0, 4.0, 7.0, LONGEST_S)
LN_EFFUSIVITY = np.linspace(np.log(20.0), np.log(50_000.0), 40)
LN_CONTACT = np.linspace(np.log(4e-4), np.log(2e-2), 20)


def felt_per_k(model: SkinModel, touched: Touched, times_s: Floats) -> Floats:
    """Return the change of the felt temperature at times after contact, for each kelvin of difference, K/K."""
    rates = skin_rates(model, touched)
    start = np.zeros(model.states)
    start[model.skin_cells :] = 1.0
    # An object without cells keeps its temperature, and the skin reaches a steady state between object and body.
    steady: Floats = np.zeros(model.states)
    if not model.ladder:
        steady = np.asarray(np.linalg.solve(rates.a, -rates.b[:, 1]), dtype=np.float64)
    decay, modes = np.linalg.eig(rates.a)
    weights = np.linalg.solve(modes, start - steady)
    seen = (rates.c[0] @ modes) * weights
    return np.asarray(rates.c[0] @ steady + (np.exp(np.outer(times_s, decay)) @ seen).real)


def largest_difference_k(error_per_k: Floats, change_per_k: Floats) -> float:
    """Return the largest difference at which the error stays within USED times the tolerance at all times, K."""
    relative = np.abs(error_per_k) > USED * TOLERANCE_SHARE * np.abs(change_per_k)
    if not relative.any():
        return ANY_K
    return min(float(USED * TOLERANCE_K / np.abs(error_per_k[relative]).max()), ANY_K)


def make_rungs(out: Path) -> Path:
    """Write the table to `out` in some seconds; return `out`."""
    largest = np.empty((len(RUNGS), len(LN_EFFUSIVITY), len(LN_CONTACT), len(DWELL_S)))
    for i, ln_effusivity in enumerate(LN_EFFUSIVITY):
        for j, ln_contact in enumerate(LN_CONTACT):
            # Any half space of this effusivity is equivalent; this one has equal conductivity and heat capacity.
            effusivity = float(np.exp(ln_effusivity))
            touched = Touched(effusivity, effusivity, 1.0, float(np.exp(ln_contact)))
            true = felt_per_k(FINE, touched, TIMES_S)
            for rung, model in enumerate(RUNGS):
                error = felt_per_k(model, touched, TIMES_S) - true
                for d, dwell_s in enumerate(DWELL_S):
                    within = dwell_s + 1e-9 >= TIMES_S
                    largest[rung, i, j, d] = largest_difference_k(error[within], true[within])
    out.parent.mkdir(parents=True, exist_ok=True)
    stored = {
        "rungs": [str(model) for model in RUNGS],
        "ln_effusivity": np.round(LN_EFFUSIVITY, 4).tolist(),
        "ln_contact": np.round(LN_CONTACT, 4).tolist(),
        "dwell_s": list(DWELL_S),
        "largest_k": [[[[float(f"{v:.3g}") for v in d] for d in r] for r in e] for e in largest.tolist()],
    }
    out.write_text(json.dumps(stored) + "\n", encoding="utf-8")
    return out
