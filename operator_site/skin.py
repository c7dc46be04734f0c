"""The three-layer finger of Kron & Schmidt 2003 (Eq. 3 and 4) as a chain of cells, exact in time.

Cells run from the far end of the object (its ladder) through the contact to the deep tissue. Eq. 4 is printed
with "the conductivity between centres"; between unlike layers that is the series value of both halves.
The system is linear, so one matrix exponential per time step and object replaces any integration error.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

Floats = NDArray[np.float64]

STEP_S = 0.01
LADDER_REACH_S = 10.0
"""The object's ladder is as deep as heat travels in this time: 4 sqrt(a t)."""
BLOOD_DENSITY_KG_M3 = 1060.0
BLOOD_SPECIFIC_HEAT_J_KGK = 3770.0


@dataclass(frozen=True, slots=True)
class Layer:
    """One layer of tissue, SI; perfusion in volumes of blood per volume of tissue and second."""

    name: str
    thickness_m: float
    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    perfusion_per_s: float


LAYERS = (
    Layer("epidermis", 0.45e-3, 0.24, 1200.0, 3590.0, 0.0),
    Layer("dermis", 1.2e-3, 0.45, 1200.0, 3300.0, 0.005),
    Layer("subcutis", 5.0e-3, 0.19, 1000.0, 2500.0, 0.00125),
)
"""The pad of a finger, outermost first."""


@dataclass(frozen=True, slots=True)
class Body:
    """The finger's surroundings; `deep_c` is the one number that differs between people."""

    air_c: float = 25.0
    deep_c: float = 34.0
    arterial_c: float = 35.0
    air_w_m2k: float = 10.0


@dataclass(frozen=True, slots=True)
class Touched:
    """An object as the finger meets it, SI; a half space when no thickness is known."""

    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    contact_m2k_w: float
    thickness_m: float | None = None


@dataclass(frozen=True, slots=True)
class SkinModel:
    """How many cells each part has; `4+1+1+6` passes for every material, `1+1+1` is the paper's least."""

    epidermis: int
    dermis: int
    subcutis: int
    ladder: int

    @property
    def skin_cells(self) -> int:
        """Number of tissue cells."""
        return self.epidermis + self.dermis + self.subcutis

    @classmethod
    def parse(cls, text: str) -> "SkinModel":
        """Read `epidermis+dermis+subcutis[+ladder]`; `3` is short for `1+1+1`.

        Without a ladder a touched object keeps its temperature for ever.

        Raises:
            ValueError: not such a sum, or a part without cells.
        """
        parts = ("1+1+1" if text.strip() == "3" else text).split("+")
        try:
            cells = [int(part) for part in parts]
        except ValueError:
            cells = []
        if len(cells) not in {3, 4} or not all(1 <= n <= 400 for n in cells):
            raise ValueError(f"model {text!r}: write cells as 4+1+1+6 (three layers and object) or 1+1+1")
        return cls(cells[0], cells[1], cells[2], cells[3] if len(cells) == 4 else 0)

    def __str__(self) -> str:
        return "+".join(map(str, (self.epidermis, self.dermis, self.subcutis, *([self.ladder] * (self.ladder > 0)))))


DEFAULT_MODEL = SkinModel(4, 1, 1, 6)


@dataclass(frozen=True, slots=True, eq=False)
class SkinStep:
    """One time step `x' = a x + b u`, `u = [outside, arterial, deep]`, and what it takes to read the flux.

    `outside` is the air, or the object's fixed temperature where the model has no ladder.
    """

    a: Floats
    b: Floats
    conductance_w_m2k: float
    """Between the outermost tissue cell and what is outside it."""
    neighbour: int
    """Index of the object's cell at the skin, or -1 when the outside is no cell."""


@dataclass(frozen=True, slots=True)
class _Chain:
    dx: Floats
    k: Floats
    heat: Floats
    blood: Floats


def _skin(model: SkinModel) -> _Chain:
    counts = (model.epidermis, model.dermis, model.subcutis)
    per_cell = [(layer, n) for layer, n in zip(LAYERS, counts, strict=True) for _ in range(n)]
    dx = np.array([layer.thickness_m / n for layer, n in per_cell])
    blood_heat = BLOOD_DENSITY_KG_M3 * BLOOD_SPECIFIC_HEAT_J_KGK
    return _Chain(
        dx,
        np.array([layer.conductivity_w_mk for layer, _ in per_cell]),
        dx * np.array([layer.density_kg_m3 * layer.specific_heat_j_kgk for layer, _ in per_cell]),
        dx * np.array([layer.perfusion_per_s * blood_heat for layer, _ in per_cell]),
    )


def ladder_m(cells: int, touched: Touched) -> Floats:
    """Thickness of the object's cells, m, the finest (last) at the skin."""
    ratio = 2.6 if cells <= 6 else 1.8 if cells <= 12 else 1.0 + 9.6 / cells
    heat = touched.density_kg_m3 * touched.specific_heat_j_kgk
    depth = 4.0 * float(np.sqrt(touched.conductivity_w_mk / heat * LADDER_REACH_S))
    if touched.thickness_m is not None:
        depth = min(depth, touched.thickness_m)
    powers = ratio ** np.arange(cells - 1, -1, -1.0)
    return np.asarray(depth * powers / powers.sum(), dtype=np.float64)


def _exact(rates: Floats, inputs: Floats, step_s: float) -> tuple[Floats, Floats]:
    n, m = inputs.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = rates, inputs
    whole = expm(block * step_s)
    return np.ascontiguousarray(whole[:n, :n]), np.ascontiguousarray(whole[:n, n:])


def _conduction(dx: Floats, k: Floats, interface: int, contact_m2k_w: float) -> Floats:
    """Conductances between neighbouring cells (Eq. 4 as series of half cells), W/m2K."""
    resistance = dx[:-1] / (2.0 * k[:-1]) + dx[1:] / (2.0 * k[1:])
    if interface >= 0:
        resistance[interface] += contact_m2k_w
    return np.asarray(1.0 / resistance, dtype=np.float64)


@lru_cache(maxsize=64)
def skin_step(model: SkinModel, touched: Touched | None, air_w_m2k: float = 10.0, step_s: float = STEP_S) -> SkinStep:
    """Matrices of one step, free (`touched` None) or in contact, kept for the next call.

    States are the ladder's cells (kept as they are in free motion), then the tissue's, outermost first.
    About 0.3 ms when new, so call it before it is needed where the object is known beforehand.
    """
    skin = _skin(model)
    n_ladder = model.ladder
    n = n_ladder + model.skin_cells
    dx, k, heat, blood = skin.dx, skin.k, skin.heat, skin.blood
    ladder = touched is not None and n_ladder > 0
    if touched is not None and ladder:
        object_dx = ladder_m(n_ladder, touched)
        object_heat = touched.density_kg_m3 * touched.specific_heat_j_kgk
        dx = np.concatenate([object_dx, dx])
        k = np.concatenate([np.full(n_ladder, touched.conductivity_w_mk), k])
        heat = np.concatenate([object_dx * object_heat, heat])
        blood = np.concatenate([np.zeros(n_ladder), blood])
    links = _conduction(dx, k, n_ladder - 1 if ladder else -1, touched.contact_m2k_w if touched else 0.0)
    outside_r = 1.0 / air_w_m2k if touched is None else touched.contact_m2k_w
    outside = 0.0 if ladder else 1.0 / (outside_r + dx[0] / (2.0 * k[0]))
    deep = 2.0 * k[-1] / dx[-1]

    size = len(dx)
    balance = np.zeros((size, size))
    cells = np.arange(size - 1)
    balance[cells, cells + 1] = balance[cells + 1, cells] = links
    balance -= np.diag(balance.sum(axis=1) + blood)
    balance[0, 0] -= outside
    balance[-1, -1] -= deep
    inputs = np.zeros((size, 3))
    inputs[0, 0] = outside
    inputs[:, 1] = blood
    inputs[-1, 2] = deep
    a, b = _exact(balance / heat[:, None], inputs / heat[:, None], step_s)
    if size < n:
        a_whole, b_whole = np.eye(n), np.zeros((n, 3))
        a_whole[n_ladder:, n_ladder:], b_whole[n_ladder:] = a, b
        a, b = a_whole, b_whole
    if ladder:
        return SkinStep(a, b, float(links[n_ladder - 1]), n_ladder - 1)
    return SkinStep(a, b, outside, -1)


def resting(model: SkinModel, body: Body) -> Floats:
    """Steady state in free motion; the ladder's cells hold the air's temperature until something is touched."""
    step = skin_step(replace(model, ladder=0), None, body.air_w_m2k)
    inputs = np.array([body.air_c, body.arterial_c, body.deep_c])
    tissue = np.linalg.solve(np.eye(model.skin_cells) - step.a, step.b @ inputs)
    return np.concatenate([np.full(model.ladder, body.air_c), tissue])


def half_cell_m2k_w(model: SkinModel) -> float:
    """Resistance between the outermost tissue cell's centre and the skin's surface, m2K/W."""
    return LAYERS[0].thickness_m / model.epidermis / 2.0 / LAYERS[0].conductivity_w_mk
