"""What a finding says: the value at its place, in what it differs from the surroundings, and in words."""

import math
from typing import NamedTuple

from operator_site.console.map.tactile_map import Felt, FeltPlace

KINDS = ("rough", "warm", "cold", "stiff", "soft", "other")
QUANTITY = {
    "rough": "roughness",
    "warm": "temperature",
    "cold": "temperature",
    "stiff": "stiffness",
    "soft": "stiffness",
}
"""What a finding of each kind is about."""
UNIT = {"temperature": "°C", "roughness": "V", "stiffness": "N/m"}
CLEAR = 2.5
"""A place differs from its surroundings where the difference is so many times its standard deviation, and"""
LEAST = {"temperature": 0.5, "roughness": 0.4, "stiffness": 0.2}
"""this large at least: K, and logarithms of the ratio."""


class Difference(NamedTuple):
    """By how much a place differs: in K, else as the logarithm of the ratio; and the standard deviation of that."""

    value: float
    sd: float

    @property
    def clear(self) -> float:
        """The difference in standard deviations."""
        return abs(self.value) / self.sd


def difference(quantity: str, here: Felt, around: Felt) -> Difference:
    """How one quantity differs from the surroundings."""
    if quantity == "temperature":
        return Difference(here.value - around.value, math.hypot(here.sd, around.sd))
    relative_sd = math.hypot(here.sd / here.value, around.sd / around.value)
    return Difference(math.log(here.value / around.value), relative_sd)


def likely_kind(here: FeltPlace, around: FeltPlace) -> str | None:
    """The kind of finding that a place looks like; None where it differs in nothing clearly."""
    best, clearest = None, CLEAR
    names = {"temperature": ("cold", "warm"), "roughness": (None, "rough"), "stiffness": ("soft", "stiff")}
    for quantity, (less, more) in names.items():
        mine, theirs = getattr(here, quantity), getattr(around, quantity)
        if mine is None or theirs is None:
            continue
        differs = difference(quantity, mine, theirs)
        if abs(differs.value) >= LEAST[quantity] and differs.clear >= clearest:
            kind = more if differs.value > 0.0 else less
            best, clearest = (kind, differs.clear) if kind else (best, clearest)
    return best


def describe(kind: str | None, here: FeltPlace) -> str:
    """A finding in words: its kind and the value that it is about; all values where it is about none.

    Raises:
        ValueError: no such kind.
    """
    if kind is not None and kind not in KINDS:
        raise ValueError(f"no kind of finding {kind!r}; there are {', '.join(KINDS)}")
    quantity = QUANTITY.get(kind or "")
    if quantity is not None:
        felt = getattr(here, quantity)
        return f"{kind}, {value_text(quantity, felt) if felt else f'{quantity} not felt here'}"
    values = [value_text(name, felt) for name in UNIT if (felt := getattr(here, name)) is not None]
    return ", ".join([*([kind] if kind else []), *(values or ["nothing felt here"])])


def compare(kind: str | None, here: FeltPlace, around: FeltPlace) -> str:
    """What a finding differs by from its surroundings, in words; empty where that is not known."""
    quantity = QUANTITY.get(kind or "")
    mine, theirs = (getattr(place, quantity) if quantity else None for place in (here, around))
    if quantity is None or mine is None or theirs is None:
        return ""
    differs = difference(quantity, mine, theirs)
    touches = f"{theirs.touches} touches" if theirs.touches != 1 else "1 touch"
    if quantity == "temperature":
        return f"{signed(differs.value, differs.sd)} K against {value_text(quantity, theirs)} around it ({touches})"
    ratio = math.exp(differs.value)
    return f"{with_sd(ratio, ratio * differs.sd)} times the {value_text(quantity, theirs)} around it ({touches})"


def value_text(quantity: str, felt: Felt) -> str:
    """A value with its standard deviation and unit, such as `36.4 ± 0.2 °C`."""
    return f"{with_sd(felt.value, felt.sd)} {UNIT[quantity]}"


def with_sd(value: float, sd: float | None) -> str:
    """A value to the place of the standard deviation's first digit, such as `24.1 ± 0.3`; `± ?` where none is known."""
    if sd is None or not math.isfinite(sd) or sd <= 0.0:
        return f"{value:.3g} ± ?"
    place = _place(sd)
    return f"{_rounded(value, place)} ± {_rounded(sd, place)}"


def signed(value: float, sd: float) -> str:
    """The same of a difference, with its sign."""
    return f"{'−' if value < 0.0 else '+'}{with_sd(abs(value), sd)}"


def _place(sd: float) -> int:
    """Decimal place of the first digit, after rounding to it."""
    place = math.floor(math.log10(sd))
    return place + (round(sd / 10.0**place) == 10)


def _rounded(value: float, place: int) -> str:
    return f"{round(value, -place):.{max(-place, 0)}f}"
