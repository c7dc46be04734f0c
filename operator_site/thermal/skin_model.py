"""Models the three-layer finger of Kron & Schmidt 2003 (Eq. 3 and 4) as a chain of cells, exact in time.

Cells run from the skin's surface to the deep tissue, then from the contact into the object (its ladder). All
temperatures are departures: of tissue from its own rest, of the object from the skin's surface at rest. Every choice of
cells therefore rests at the same temperatures, and a finger at rest is all zeros. Eq. 4 is printed with "the
conductivity between centres"; between unlike layers that is the series value of both halves. The system is linear, so
one matrix exponential per time step and object leaves no integration error.
"""

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from scipy.linalg import expm

from common.scenes.materials import material
from operator_site.thermal.tissue import Cells, Floats, cells

STEP_S = 0.01
"""Time step of the model, s."""
LADDER_REACH_S = 10.0
"""Time that sets the depth of the object's ladder, s: heat travels 4 sqrt(a t)."""
INPUTS = 2
"""Number of inputs: the flux at rest, W/m2, and the temperature of an object without cells, K as departure."""
OUTPUTS = 5
"""Number of outputs: departures of epidermis, dermis, subcutis and surface, K, and the flux into the skin, W/m2."""
MOST_CELLS = 400
"""Maximum number of cells of one part in a parsed model."""


def contact_resistance_m2k_w(conductivity_w_mk: float) -> float:
    """Return the thermal contact resistance between a bare finger and an object, m2K/W.

    R_c = (0.37 + k)/(1870 k) after Ho & Jones 2008. This is too low for hard conductors, so the result is at least
    1e-3, which matches measured skin temperatures of people.
    """
    return max(1e-3, (0.37 + conductivity_w_mk) / (1870.0 * conductivity_w_mk))


@dataclass(frozen=True, slots=True)
class Touched:
    """Thermal properties of a touched object, which is a half space, and its contact, SI."""

    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    contact_m2k_w: float

    @classmethod
    def of(cls, name: str) -> "Touched":
        """Return an object of a material by its name or alias; raises KeyError where the material is unknown."""
        known = material(name)
        k = known.conductivity_w_mk
        return cls(k, known.density_kg_m3, known.specific_heat_j_kgk, contact_resistance_m2k_w(k))


@dataclass(frozen=True, slots=True)
class SkinModel:
    """Number of cells of each part; without a ladder a touched object keeps its temperature permanently."""

    epidermis: int
    dermis: int
    subcutis: int
    ladder: int = 0

    @property
    def tissue(self) -> Cells:
        """The cells of the tissue."""
        return cells((self.epidermis, self.dermis, self.subcutis))

    @property
    def skin_cells(self) -> int:
        """Number of tissue cells."""
        return self.epidermis + self.dermis + self.subcutis

    @property
    def states(self) -> int:
        """Number of all cells."""
        return self.skin_cells + self.ladder

    @classmethod
    def parse(cls, text: str) -> "SkinModel":
        """Read `epidermis+dermis+subcutis[+ladder]`; `3` is short for `1+1+1`.

        Raises:
            ValueError: the text is no such sum, or a part is not in 1..MOST_CELLS.
        """
        parts = ("1+1+1" if text.strip() == "3" else text).split("+")
        try:
            counts = [int(part) for part in parts]
        except ValueError:
            counts = []
        if len(counts) not in {3, 4} or not all(1 <= n <= MOST_CELLS for n in counts):
            raise ValueError(f"model {text!r}: write cells as 4+1+1+6 (three layers and object) or 1+1+1")
        return cls(*counts)

    def __str__(self) -> str:
        return "+".join(map(str, (self.epidermis, self.dermis, self.subcutis, *([self.ladder] * (self.ladder > 0)))))


@dataclass(frozen=True, slots=True, eq=False)
class SkinStep:
    """One time step `x' = a x + b u` and the outputs of a state, `y = c x + d u`."""

    a: Floats
    b: Floats
    c: Floats
    d: Floats


def ladder_m(count: int, touched: Touched) -> Floats:
    """Return the thickness of the object's cells, m; the first and thinnest one is at the skin."""
    ratio = 2.6 if count <= 6 else 1.8 if count <= 12 else 1.0 + 9.6 / count
    heat = touched.density_kg_m3 * touched.specific_heat_j_kgk
    depth = 4.0 * float(np.sqrt(touched.conductivity_w_mk / heat * LADDER_REACH_S))
    powers = ratio ** np.arange(count, dtype=np.float64)
    return np.asarray(depth * powers / powers.sum(), dtype=np.float64)


@lru_cache(maxsize=256)
def skin_rates(model: SkinModel, touched: Touched | None, air_w_m2k: float = 10.0) -> SkinStep:
    """Return the rates `dx/dt = a x + b u`, 1/s, and the outputs, free (`touched` None, tissue alone) or in contact."""
    half_m2k_w, heat, own_balance, means = _tissue(model)
    m = model.skin_cells
    count = 0 if touched is None else model.ladder
    n = m + count
    balance = np.zeros((n, n))
    balance[:m, :m] = own_balance
    flux, flux_of = np.zeros(n), np.zeros(INPUTS)
    if touched is None:
        flux[0], flux_of[0] = -1.0 / (1.0 / air_w_m2k + half_m2k_w), 1.0
    else:
        half_object = 0.0
        if count:
            size = ladder_m(count, touched)
            halves = size / (2.0 * touched.conductivity_w_mk)
            half_object = float(halves[0])
            heat = np.concatenate((heat, size * touched.density_kg_m3 * touched.specific_heat_j_kgk))
            _link(balance, 1.0 / (halves[:-1] + halves[1:]), m)
        conducts = 1.0 / (half_object + touched.contact_m2k_w + half_m2k_w)
        flux[0], flux_of[0] = -conducts, conducts * half_m2k_w
        if count:
            flux[m] = conducts
        else:
            flux_of[1] = conducts
    gained = flux_of - np.array([1.0, 0.0])  # relative to the flux at rest, which maintains the rest
    inputs = np.zeros((n, INPUTS))
    balance[0] += flux
    inputs[0] = gained
    if count:
        balance[m] -= flux
        inputs[m] = -flux_of
    c, d = np.zeros((OUTPUTS, n)), np.zeros((OUTPUTS, INPUTS))
    c[:3, :m] = means
    c[3] = half_m2k_w * flux
    c[3, 0] += 1.0
    d[3] = half_m2k_w * gained
    c[4], d[4] = flux, flux_of
    return SkinStep(balance / heat[:, None], inputs / heat[:, None], c, d)


@cache
def _tissue(model: SkinModel) -> tuple[float, Floats, Floats, Floats]:
    """Return the parts that no object changes, cached for each model.

    These are the resistance of half the first cell, m2K/W, the heat capacities, J/m2K, the balance of the tissue alone,
    W/m2K, and the weights of the layer means.
    """
    tissue, m = model.tissue, model.skin_cells
    balance = np.zeros((m, m))
    _link(balance, tissue.links_w_m2k, 0)
    skin = np.arange(m)
    balance[skin, skin] -= tissue.blood_w_m2k
    balance[m - 1, m - 1] -= tissue.deep_w_m2k
    layers = [tissue.layer_of == layer for layer in range(3)]
    return tissue.half_m2k_w, tissue.heat_j_m2k, balance, np.array([mine / mine.sum() for mine in layers])


def _link(balance: Floats, links: Floats, first: int) -> None:
    """Couple neighbouring cells from `first` on."""
    at = first + np.arange(len(links))
    balance[at, at + 1] += links
    balance[at + 1, at] += links
    balance[at, at] -= links
    balance[at + 1, at + 1] -= links


@lru_cache(maxsize=256)
def skin_step(model: SkinModel, touched: Touched | None, air_w_m2k: float = 10.0, step_s: float = STEP_S) -> SkinStep:
    """Return one step, free (tissue alone) or in contact, exact for constant inputs; cached.

    A new one takes about 0.3 ms, so call it in advance for objects that are known beforehand.
    """
    rates = skin_rates(model, touched, air_w_m2k)
    n = len(rates.a)
    block = np.zeros((n + INPUTS, n + INPUTS))
    block[:n, :n], block[:n, n:] = rates.a, rates.b
    whole = expm(block * step_s)
    return SkinStep(np.ascontiguousarray(whole[:n, :n]), np.ascontiguousarray(whole[:n, n:]), rates.c, rates.d)


def refined(x: Floats, old: SkinModel, new: SkinModel) -> Floats:
    """Convert departures (old.states,), K, to the cells of `new`: interpolate profiles, keep layer and object means."""
    before, after = old.tissue, new.tissue
    m, k = old.skin_cells, new.skin_cells
    result = np.zeros(new.states)
    profile = np.interp(after.centres_m, before.centres_m, x[:m])
    mean = np.bincount(before.layer_of, x[:m]) / np.bincount(before.layer_of)
    shift = mean - np.bincount(after.layer_of, profile) / np.bincount(after.layer_of)
    result[:k] = profile + shift[after.layer_of]
    if old.ladder and new.ladder:
        unit = Touched(1.0, 1.0, 1.0, 0.0)
        coarse, fine = ladder_m(old.ladder, unit), ladder_m(new.ladder, unit)
        depths = np.interp(np.cumsum(fine) - 0.5 * fine, np.cumsum(coarse) - 0.5 * coarse, x[m:])
        result[k:] = depths + float(np.average(x[m:], weights=coarse) - np.average(depths, weights=fine))
    return result
