"""Describes a finding in words: the value at its place, and its difference from the surroundings."""

import math
from typing import NamedTuple

from common.wire.roughness_um import RoughnessUm
from operator_site.console.map.roughness_shown import roughness_shown
from operator_site.console.map.tactile_map import ExploredPlace, Measured
from operator_site.console.texts import count

KINDS = ("rough", "warm", "cold", "stiff", "soft", "other", "tender")
TENDER = "tender"
"""Kind of a place that hurts; it has no measured quantity."""
QUANTITY = {
    "rough": "roughness",
    "warm": "temperature",
    "cold": "temperature",
    "stiff": "stiffness",
    "soft": "stiffness",
}
"""Measured quantity of each kind of finding."""
UNIT = {"temperature": "°C", "stiffness": "N/m"}
MEASURED = ("temperature", "roughness", "stiffness")
CLEAR = 2.5
"""Smallest clear difference from the surroundings, in standard deviations of the difference."""
LEAST = {"temperature": 0.5, "roughness": 0.4, "stiffness": 0.2}
"""Smallest clear difference from the surroundings, K or natural logarithm of the ratio."""
LUMP = 0.55
"""Smallest probability of a lump at which a place is called stiff."""
UNCERTAIN_SD_K = 1.0
"""Standard deviation above which a temperature is called uncertain, K.

A fever or an inflammation warms skin by about 2 K, which is then less than two standard deviations.
"""


class Difference(NamedTuple):
    """Difference of a place and its standard deviation: in K, or as the natural logarithm of the ratio."""

    value: float
    sd: float

    @property
    def clear(self) -> float:
        """The difference in standard deviations."""
        return abs(self.value) / self.sd


def difference(quantity: str, here: Measured, around: Measured) -> Difference:
    """Return the difference of one quantity from the surroundings."""
    if quantity == "temperature":
        return Difference(here.value - around.value, math.hypot(here.sd, around.sd))
    relative_sd = math.hypot(here.sd / here.value, around.sd / around.value)
    return Difference(math.log(here.value / around.value), relative_sd)


def likely_kind(here: ExploredPlace, around: ExploredPlace) -> str | None:
    """Return the likely kind of finding at a place; None if no quantity differs clearly.

    The probability of a lump decides whether a place is stiff, where it is known.
    """
    best, clearest = None, CLEAR
    names = {"temperature": ("cold", "warm"), "roughness": (None, "rough"), "stiffness": ("soft", "stiff")}
    for quantity, (less, more) in names.items():
        mine, theirs = getattr(here, quantity), getattr(around, quantity)
        if mine is None or theirs is None:
            continue
        differs = difference(quantity, mine, theirs)
        if quantity == "stiffness" and here.lump is not None and (differs.value > 0.0 or here.lump >= LUMP):
            if here.lump >= LUMP and max(differs.clear, CLEAR) >= clearest:
                best, clearest = more, max(differs.clear, CLEAR)
            continue
        if abs(differs.value) >= LEAST[quantity] and differs.clear >= clearest:
            kind = more if differs.value > 0.0 else less
            best, clearest = (kind, differs.clear) if kind else (best, clearest)
    return best


def describe(kind: str | None, here: ExploredPlace, scale: RoughnessUm | None = None) -> str:
    """Describe a finding in words: its kind and its value, or all values if its kind has no quantity.

    Of a tender place, the kind alone: see `tender_finding` for the rest.

    Raises:
        ValueError: no such kind.
    """
    if kind is not None and kind not in KINDS:
        raise ValueError(f"no kind of finding {kind!r}; there are {', '.join(KINDS)}")
    if kind == TENDER:
        return TENDER
    quantity = QUANTITY.get(kind or "")
    if quantity is not None:
        measured = getattr(here, quantity)
        return f"{kind}, {value_text(quantity, measured, scale) if measured else f'{quantity} not felt here'}"
    values = [value_text(name, value, scale) for name in MEASURED if (value := getattr(here, name)) is not None]
    return ", ".join([*([kind] if kind else []), *(values or ["nothing felt here"])])


def compare(quantity: str | None, here: ExploredPlace, around: ExploredPlace, scale: RoughnessUm | None = None) -> str:
    """Describe the difference of a place from its surroundings in one quantity in words; empty if unknown."""
    mine, theirs = (getattr(place, quantity) if quantity else None for place in (here, around))
    if quantity is None or mine is None or theirs is None:
        return ""
    differs = difference(quantity, mine, theirs)
    touches = count(theirs.touches, "touch")
    if quantity == "temperature":
        return (
            f"{signed(differs.value, differs.sd)} K against {value_text(quantity, theirs, scale)} around it ({touches})"
        )
    ratio = math.exp(differs.value)
    return f"{with_sd(ratio, ratio * differs.sd)} times the {value_text(quantity, theirs, scale)} around it ({touches})"


def value_text(quantity: str, measured: Measured, scale: RoughnessUm | None = None) -> str:
    """Format a value with its standard deviation and unit: `36.4 ± 0.2 °C`, or `31 ± 2 °C, uncertain`.

    A roughness is in um where its `scale` holds, else a level of 10.
    """
    if quantity == "roughness":
        shown = roughness_shown(measured.value, measured.sd, scale)
        return f"{with_sd(shown.value, shown.sd)} {shown.unit}"
    uncertain = quantity == "temperature" and measured.sd > UNCERTAIN_SD_K
    return f"{with_sd(measured.value, measured.sd)} {UNIT[quantity]}{', uncertain' if uncertain else ''}"


def with_sd(value: float, sd: float | None) -> str:
    """Round a value to the first digit of its standard deviation, such as `24.1 ± 0.3`; `± ?` if that is unknown."""
    if sd is None or not math.isfinite(sd) or sd <= 0.0:
        return f"{value:.3g} ± ?"
    place = _place(sd)
    return f"{_rounded(value, place)} ± {_rounded(sd, place)}"


def signed(value: float, sd: float) -> str:
    """Format a difference as `with_sd` does, with its sign."""
    return f"{'−' if value < 0.0 else '+'}{with_sd(abs(value), sd)}"


def _place(sd: float) -> int:
    """Return the decimal place of the first digit after rounding to it."""
    place = math.floor(math.log10(sd))
    return place + (round(sd / 10.0**place) == 10)


def _rounded(value: float, place: int) -> str:
    return f"{round(value, -place):.{max(-place, 0)}f}"
