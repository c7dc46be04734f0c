"""Maps the failures of identification: small difference, noise, lost contact, scattering contacts, foreign materials.

Each map has a list of cells over its varied conditions, and rows made of their answers.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from common.scenes.materials import material, materials
from sim_sensors.physics.ssr_converter import NOISE_C
from studies.pieces import Piece
from studies.thermal_identification.answers import Answered
from studies.thermal_identification.pieces import in_session, with_noise
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


def map_cells(axes: Axes, tables: Mapping[float, str], seed: int) -> dict[str, list[Cell]]:
    """Return the cells of each map; `tables` are those of four materials, by the noise of a reading, K.

    With uncalibrated materials every `identified` is wrong, and `right` has no meaning.
    """
    usual = {NOISE_C: tables[NOISE_C]}

    def cell(
        columns: Sequence[Mapping[str, Any]],
        names: Sequence[str] = FOUR,
        answer: Callable[..., list[list[Answered]]] = with_noise,
        known: Any = usual,
        **how: Any,
    ) -> Cell:
        touched = (Situation(name, seed, axes.touches, seconds=axes.seconds, **how) for name in names)
        return Cell(columns, [(answer, (each, known, axes.times_s)) for each in touched])

    return {
        "difference": [
            cell(
                [{"difference_k": difference_k, "noise_k": noise_k} for noise_k in axes.noises_k],
                known=tables,
                offset_c=(PREHEAT_K - difference_k,) * 2,
            )
            for difference_k in axes.differences_k
        ],
        "contact": [
            cell(
                [{"change_s": at_s, "force_share": share}],
                answer=in_session,
                known=tables[NOISE_C],
                later=(at_s, share),
            )
            for at_s, share in axes.changes
        ],
        "spread": [cell([{"contact_spread": spread}], contact_spread=spread) for spread in axes.spreads],
        "untrained": [
            cell([{"material": name, "away_ln": round(away_ln, 3)}], (name,))
            for name, away_ln in foreign_materials(axes)
        ],
    }


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
