"""Surfaces that a scene may name, with their effect on a finger.

`surfaces.toml` holds the constants and explains each.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from common.files.constants import read_constants, within
from common.files.read_files import read_tables
from common.wire.messages import TOUCH_RANGES

_RANGES = {
    "stiffness_n_m": (50.0, TOUCH_RANGES["stiffness_n_m"][1]),
    **{name: TOUCH_RANGES[name] for name in ("k_tap", "b_tap_per_s", "k_stroke_v", "k_stroke_f")},
}
"""Constants of every surface, with the ranges that a touch packet can carry."""
_GROOVE_RANGES = {"impulse_rad_s": TOUCH_RANGES["groove_rad_s"], "decay_per_s": TOUCH_RANGES["b_groove_per_s"]}
STIFFNESS_N_M = _RANGES["stiffness_n_m"]
"""Stiffness of the softest and of the stiffest object, N/m."""
_CLOSEST_M = 0.5e-3
"""Minimum distance between grooves that a finger can resolve, m."""


@dataclass(frozen=True, slots=True)
class Grooves:
    """Grooves across x: distance between neighbours (minimum, maximum), m; impulse, rad/s; decay, 1/s."""

    apart_m: tuple[float, float]
    impulse_rad_s: float
    decay_per_s: float

    def draw(self, length_m: float, rng: np.random.Generator) -> list[float]:
        """Draw the distances of the grooves on a piece from its near edge, ascending, m."""
        low, high = self.apart_m
        places = []
        place = 0.5 * low
        while place <= length_m - 0.5 * low + 1e-9:
            places.append(place)
            place += rng.uniform(low, high) if high > low else low
        return places


@dataclass(frozen=True, slots=True)
class SurfaceKind:
    """One kind of surface; `grooves` is None for a surface without grooves."""

    name: str
    stiffness_n_m: float
    k_tap: float
    b_tap_per_s: float
    k_stroke_v: float
    k_stroke_f: float
    grooves: Grooves | None = None


@cache
def surfaces() -> dict[str, SurfaceKind]:
    """Return all known surfaces by name."""
    return read_surfaces(Path(__file__).parent / "constants" / "surfaces.toml")


def read_surfaces(path: Path) -> dict[str, SurfaceKind]:
    """Return the surfaces of a file by name.

    Raises:
        ValueError: a constant is missing, unknown, not a number, or out of range; the message names file, surface
            and constant.
    """
    known = {}
    for name, given in read_tables(path).items():
        where = f"{path}: {name}"
        constants = read_constants(given, _RANGES, where, beside="grooves")
        known[name] = SurfaceKind(name, **constants, grooves=_grooves(given.get("grooves"), f"{where}: grooves"))
    return known


def surface_kind(name: str) -> SurfaceKind:
    """Look a surface up by name; raises ValueError, which lists the known ones, where there is no such surface."""
    try:
        return surfaces()[name]
    except KeyError:
        raise ValueError(f"unknown surface {name!r}; known: {', '.join(sorted(surfaces()))}") from None


def _grooves(given: object, where: str) -> Grooves | None:
    if given is None:
        return None
    constants = read_constants(given, _GROOVE_RANGES, where, beside="apart_m")
    match given:
        case {"apart_m": [low, high]} if within(low, _CLOSEST_M, 1.0) and within(high, low, 1.0):
            return Grooves((low, high), **constants)
    raise ValueError(f"{where}: apart_m must be [smallest, largest] distance from {_CLOSEST_M:g} to 1")
