"""Judges the tactile map and its lump probabilities on recorded presses of phantoms with stiff parts.

The recordings state no place of a lump. The truth is inferred from the denser or deeper recording of each phantom, in
cells of 1 mm (`truth/NAME.csv`). A map of some presses is compared with it:

- the AUC of the cells' stiffness, and of their lump probability, from random presses;
- Dice's coefficient of the cells with a lump probability of at least 0.5;
- the AUC of single presses that are cut at 1.1 mm;
- the share of the cells inside and outside of lumps that the console calls stiff, from all presses;
- the AUC from presses that `next_press` chose one by one, beside evenly spread and random ones.

The lengths and priors of the map were chosen with these recordings. Other recordings are kept aside to judge it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.stats import rankdata

from operator_site.console.examination.findings import LUMP
from operator_site.palpation.lump_probability import lumps_of_field, search_of_field
from operator_site.palpation.next_press import best
from operator_site.palpation.stiffness_field import StiffnessField
from remote_site.traces.press_files import Press, read_presses
from remote_site.traces.trace_files import TraceFile
from studies.counting import grouped
from teletaction.mapping.map_recorded import stiffnesses

Array = NDArray[np.float64]
Row = dict[str, Any]
SETS = {"kidney_bar_t1": "kidney_bar", "kidney_bar_t2": "kidney_bar", "organ_balls": "organ_balls"}
"""Sets of presses, and the phantom whose lumps they cover."""
NUMBERS = (30, 60, 120)
"""Numbers of random presses of a map."""
NEXT_NUMBERS = (20, 30, 45, 60)
"""Numbers of presses chosen one by one; the first FIRST are random."""
FIRST = 10
"""Number of random presses before the chosen ones."""
SCORES = ("auc_value", "auc_lump", "dice", "called", "called_false")
"""Scores of a map."""
CUT_MM = 1.1
"""Depth at which presses are cut for the judgement of single presses, mm."""
DICE_AT = 0.5
"""Lump probability from which a cell counts as a lump for Dice's coefficient; from no phantom."""
NEAR_MM = 1.0
"""Largest distance of a used press from a cell of the truth, mm; the table around a phantom is left out."""
UPRIGHT = 0.82
"""Smallest vertical part of a used press's normal: 35 degrees, as in the truth."""


class Truth(NamedTuple):
    """Cells of a phantom: places, (n, 2), m, and whether each belongs to a lump, (n,)."""

    places_m: Array
    lump: NDArray[np.bool_]


class Mapped(NamedTuple):
    """Presses for maps: places, (n, 2), m, ln stiffness (N/m) and its variance, (n,)."""

    places_m: Array
    value: Array
    variance: Array

    def some(self, chosen: Any) -> "Mapped":
        """Return some of the presses."""
        return Mapped(self.places_m[chosen], self.value[chosen], self.variance[chosen])

    def field(self) -> StiffnessField:
        """Return their field."""
        return StiffnessField(*self)


class Palpated(NamedTuple):
    """One set of presses on a phantom: its name, the presses, and the phantom's cells."""

    name: str
    presses: list[Press]
    truth: Truth


def read_palpated(folder: Path, name: str) -> Palpated:
    """Return one of SETS; the cells are in `x_mm,y_mm,lump`; raises ValueError where a file cannot be read."""
    cells = TraceFile(folder / "truth" / f"{SETS[name]}.csv")
    places_m = 1e-3 * np.column_stack([cells.numbers(axis) for axis in ("x_mm", "y_mm")])
    lump = np.array([text != "0" for _, text in cells.texts("lump")])
    return Palpated(name, read_presses(folder / name / "presses.csv"), Truth(places_m, lump))


def mapped(presses: list[Press], truth: Truth, cut_mm: float = np.inf) -> Mapped:
    """Return the usable presses over the truth's cells, each cut at a depth, mm; raise ValueError without one."""
    cut, rows = [_cut(press, cut_mm) for press in presses if _upright(press)], []
    for press, found in zip(cut, stiffnesses(cut), strict=True):
        if found is not None and press.at_mm is not None:
            rows.append((1e-3 * press.at_mm[0], 1e-3 * press.at_mm[1], *found))
    if not rows:
        raise ValueError("no press with a place and a stiffness")
    every = np.array(rows)
    near = cdist(every[:, :2], truth.places_m).min(axis=1) <= 1e-3 * NEAR_MM
    return Mapped(every[near, :2], every[near, 2], every[near, 3])


def _cut(press: Press, cut_mm: float) -> Press:
    shallow = press.depth_mm <= cut_mm
    place_mm = None if press.place_mm is None else press.place_mm[shallow]
    return replace(
        press, depth_mm=press.depth_mm[shallow], force_n=press.force_n[shallow], time_s=None, place_mm=place_mm
    )


def _upright(press: Press) -> bool:
    normal = None if press.contact is None else press.contact.normal
    return normal is None or float(normal[2]) >= UPRIGHT


def judged_maps(palpated: Palpated, draws: int) -> Iterator[Row]:
    """Yield the rows of one set of presses, of `draws` random choices each."""
    name, presses, truth = palpated
    every = mapped(presses, truth)
    for number in NUMBERS:
        for seed in range(draws):
            chosen = np.random.default_rng(seed).choice(len(every.value), number, replace=False)
            yield {"set": name, "seed": seed, **scored(every.some(chosen), truth)}
    yield {"set": name, "seed": None, **scored(every, truth), "way": "all presses"}
    cut = mapped(presses, truth, CUT_MM)
    nearest = cdist(cut.places_m, truth.places_m)
    inside = nearest.min(axis=1) < 1e-3
    value = cut.field().at(cut.places_m).mean
    lump = truth.lump[nearest.argmin(axis=1)]
    yield {"set": name, "seed": None, "way": "single presses, cut", "auc_value": auc(value[inside], lump[inside])}


def scored(presses: Mapped, truth: Truth) -> Row:
    """Return the scores of a map of some presses."""
    field = presses.field()
    value, lump = field.at(truth.places_m).mean, lumps_of_field(field).probability(truth.places_m)
    return {
        "way": "random",
        "presses": len(presses.value),
        "auc_value": auc(value, truth.lump),
        "auc_lump": auc(lump, truth.lump),
        "dice": dice(lump >= DICE_AT, truth.lump),
        "called": float((lump >= LUMP)[truth.lump].mean()),
        "called_false": float((lump >= LUMP)[~truth.lump].mean()),
    }


def chosen_one_by_one(palpated: Palpated, seed: int) -> Iterator[Row]:
    """Yield the AUC of lump probabilities from presses chosen one by one, by each way of choosing."""
    name, presses, truth = palpated
    every = mapped(presses, truth)
    order = np.random.default_rng(seed).permutation(len(every.value))
    for way, choose in _WAYS.items():
        chosen = order[:FIRST].tolist()
        while len(chosen) <= max(NEXT_NUMBERS):
            if len(chosen) in NEXT_NUMBERS:
                yield {"set": name, "seed": seed, **scored(every.some(chosen), truth), "way": way}
            rest = np.setdiff1d(order, chosen, assume_unique=True)
            chosen.append(int(rest[choose(every, chosen, rest)]))


def _informative(every: Mapped, chosen: list[int], rest: NDArray[np.intp]) -> int:
    return best(search_of_field(every.some(chosen).field()), every.places_m[rest])[0]


def _spread(every: Mapped, chosen: list[int], rest: NDArray[np.intp]) -> int:
    return int(cdist(every.places_m[rest], every.places_m[chosen]).min(axis=1).argmax())


_WAYS: dict[str, Callable[[Mapped, list[int], NDArray[np.intp]], int]] = {
    "next_press": _informative,
    "spread": _spread,
    "random": lambda every, chosen, rest: 0,
}


def map_means(rows: Sequence[Row]) -> list[Row]:
    """Return the mean scores over the seeds of each set, way and number of presses."""
    drawn = [row for row in rows if row["seed"] is not None]
    return [
        {"set": name, "way": way, "presses": presses}
        | {score: float(np.mean([row[score] for row in mine])) for score in SCORES}
        for (name, way, presses), mine in grouped(drawn, "set", "way", "presses").items()
    ]


def auc(score: Array, lump: NDArray[np.bool_]) -> float:
    """Return the probability that a lump's score is above another's; equal scores count half."""
    ranks, inside = rankdata(score), int(lump.sum())
    return float((ranks[lump].sum() - 0.5 * inside * (inside + 1)) / (inside * (len(lump) - inside)))


def dice(called: NDArray[np.bool_], lump: NDArray[np.bool_]) -> float:
    """Return Dice's coefficient of two areas; 1 if both are empty."""
    both = int(called.sum() + lump.sum())
    return 2.0 * float((called & lump).sum()) / both if both else 1.0
