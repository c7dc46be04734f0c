"""Maps the failures of identification: small difference, noise, lost contact, scattering contacts, foreign materials.

Each map has a list of cells over its varied conditions, and rows made of their answers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from common.scenes.materials import material, materials
from studies.pieces import Piece
from studies.thermal_identification.answers import Answered
from studies.thermal_identification.pieces import in_session, one_finger, with_noise
from studies.thermal_identification.shares import shares
from studies.thermal_identification.situations import FOUR, PREHEAT_K, SECONDS, Situation


@dataclass(frozen=True, slots=True)
class Axes:
    """Axes of the maps.

    Attributes:
        differences_k: plate minus object at contact, K; the plate has its usual pre-heat, and the object varies.
        noises_k: standard deviation of a reading, K; the simulator's own is the first.
        changes: time of a change of contact, s after contact, and remaining share of the force (0: lifted).
        spreads: standard deviation of ln(contact conductance); the calibration's is 0.15.
        foreign: number of foreign materials.
        touches: touches of each material in each cell.
        times_s: times of the judged answers, s after contact.
        seconds: time in contact, s.
    """

    differences_k: tuple[float, ...]
    noises_k: tuple[float, ...]
    changes: tuple[tuple[float, float], ...]
    spreads: tuple[float, ...]
    foreign: int
    touches: int
    times_s: tuple[float, ...]
    seconds: float = SECONDS


class Cell(NamedTuple):
    """A cell of a map: its columns for each answer of a piece, and its pieces, which answer a list for each."""

    columns: Sequence[Mapping[str, Any]]
    pieces: Sequence[Piece]


def difference_cells(axes: Axes, tables: dict[float, str], seed: int) -> list[Cell]:
    """Return cells over difference x noise x time."""
    return [
        Cell(
            [{"difference_k": difference_k, "noise_k": noise_k} for noise_k in axes.noises_k],
            [
                (with_noise, (_situation(axes, name, seed, offset_c=(above_k, above_k)), tables, axes.times_s))
                for name in FOUR
            ],
        )
        for difference_k, above_k in ((each, PREHEAT_K - each) for each in axes.differences_k)
    ]


def change_cells(axes: Axes, table: str, seed: int) -> list[Cell]:
    """Return cells with a lost or changed contact."""
    return [
        Cell(
            [{"change_s": at_s, "force_share": share}],
            [(in_session, (_situation(axes, name, seed, later=(at_s, share)), table, axes.times_s)) for name in FOUR],
        )
        for at_s, share in axes.changes
    ]


def spread_cells(axes: Axes, table: str, seed: int) -> list[Cell]:
    """Return cells with another scatter of contacts than in calibration."""
    return [
        Cell(
            [{"contact_spread": spread}],
            [(one_finger, (_situation(axes, name, seed, contact_spread=spread), table, axes.times_s)) for name in FOUR],
        )
        for spread in axes.spreads
    ]


def foreign_cells(axes: Axes, table: str, seed: int) -> list[Cell]:
    """Return cells with uncalibrated materials; every `identified` is wrong, and `right` has no meaning."""
    return [
        Cell(
            [{"material": name, "away_ln": round(away_ln, 3)}],
            [(one_finger, (_situation(axes, name, seed), table, axes.times_s))],
        )
        for name, away_ln in foreign_materials(axes)
    ]


def cell_rows(cells: Sequence[Cell], found: Sequence[Sequence[Sequence[Answered]]]) -> list[dict[str, Any]]:
    """Return the rows of the cells from the results of all their pieces."""
    done, rows = iter(found), list[dict[str, Any]]()
    for cell in cells:
        results = [next(done) for _ in cell.pieces]
        for columns, answers in zip(cell.columns, zip(*results, strict=True), strict=True):
            rows += shares(list(chain(*answers)), **columns)
    return rows


def foreign_materials(axes: Axes) -> list[tuple[str, float]]:
    """Return uncalibrated materials with the signed distance to the nearest calibrated one, in ln effusivity."""
    calibrated = [np.log(material(name).effusivity) for name in FOUR]
    away = []
    for name, kind in materials().items():
        if name not in FOUR:
            distances = np.log(kind.effusivity) - calibrated
            away.append((name, float(distances[np.argmin(np.abs(distances))])))
    away.sort(key=lambda each: abs(each[1]))
    places = np.unique(np.linspace(0, len(away) - 1, axes.foreign).round().astype(int))
    return [away[place] for place in places]


def _situation(axes: Axes, name: str, seed: int, **how: Any) -> Situation:
    return Situation(name, seed, axes.touches, seconds=axes.seconds, **how)
