"""Where identification fails: little difference and much noise, contact lost, contacts that scatter, foreign materials.

Each map is a list of pieces with what it varies, and the rows that their answers make.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from common.materials import material, materials
from sim_sensors.ssr_converter import NOISE_C
from studies.pieces import Piece
from studies.thermal_answers import Answered
from studies.thermal_pieces import in_session, one_finger, with_noise
from studies.thermal_shares import shares
from studies.thermal_situations import FOUR, PREHEAT_K, SECONDS, Situation

FAR_LN = 0.5
"""A foreign material so far away in ln effusivity from every calibrated one has to be told from them."""


@dataclass(frozen=True, slots=True)
class Axes:
    """What the maps are drawn over.

    Attributes:
        differences_k: plate minus object at contact, K; the plate is at its usual pre-heat, the object is not.
        noises_k: of a reading, standard deviation, K.
        changes: when a contact changes, s after it began, and the share of its force that is left (0: lifted).
        spreads: standard deviation of ln(contact conductance); the calibration's is 0.15.
        foreign: number of foreign materials.
        touches: of each material in each cell.
        times_s: when answers are looked at.
        seconds: in contact, s.
    """

    differences_k: tuple[float, ...]
    noises_k: tuple[float, ...]
    changes: tuple[tuple[float, float], ...]
    spreads: tuple[float, ...]
    foreign: int
    touches: int
    times_s: tuple[float, ...]
    seconds: float = SECONDS


def difference_pieces(axes: Axes, tables: dict[float, str], seed: int) -> list[Piece]:
    """Difference x noise x time; a piece for each difference and material."""
    return [
        (with_noise, (_situation(axes, name, seed, offset_c=(above_k, above_k)), tables, axes.times_s))
        for above_k in (PREHEAT_K - difference_k for difference_k in axes.differences_k)
        for name in FOUR
    ]


def difference_rows(axes: Axes, found: Sequence[list[tuple[float, list[Answered]]]]) -> list[dict[str, Any]]:
    """Of the results of `difference_pieces`."""
    rows = []
    for place, difference_k in enumerate(axes.differences_k):
        cell = found[place * len(FOUR) : (place + 1) * len(FOUR)]
        for number, noise_k in enumerate(axes.noises_k):
            answers = [answer for each in cell for answer in each[number][1]]
            rows += shares(answers, difference_k=difference_k, noise_k=noise_k)
    return rows


def change_pieces(axes: Axes, table: str, seed: int) -> list[Piece]:
    """Contact lost or pressed otherwise; a piece for each change and material."""
    return [
        (in_session, (_situation(axes, name, seed, later=change), table, axes.times_s))
        for change in axes.changes
        for name in FOUR
    ]


def change_rows(axes: Axes, found: Sequence[list[Answered]]) -> list[dict[str, Any]]:
    """Of the results of `change_pieces`."""
    rows = []
    for place, (at_s, share) in enumerate(axes.changes):
        rows += shares(_cell(found, place), change_s=at_s, force_share=share)
    return rows


def spread_pieces(axes: Axes, table: str, seed: int) -> list[Piece]:
    """Contacts that scatter otherwise than in calibration; a piece for each spread and material."""
    return [
        (one_finger, (_situation(axes, name, seed, contact_spread=spread), table, axes.times_s))
        for spread in axes.spreads
        for name in FOUR
    ]


def spread_rows(axes: Axes, found: Sequence[list[Answered]]) -> list[dict[str, Any]]:
    """Of the results of `spread_pieces`."""
    rows = []
    for place, spread in enumerate(axes.spreads):
        rows += shares(_cell(found, place), contact_spread=spread)
    return rows


def foreign_materials(axes: Axes) -> list[tuple[str, float]]:
    """Materials that were not calibrated, and how far each is from the nearest that was, in ln effusivity, signed."""
    calibrated = [np.log(material(name).effusivity) for name in FOUR]
    away = []
    for name, kind in materials().items():
        if name not in FOUR:
            distances = np.log(kind.effusivity) - calibrated
            away.append((name, float(distances[np.argmin(np.abs(distances))])))
    away.sort(key=lambda each: abs(each[1]))
    places = np.unique(np.linspace(0, len(away) - 1, axes.foreign).round().astype(int))
    return [away[place] for place in places]


def foreign_pieces(axes: Axes, table: str, seed: int) -> list[Piece]:
    """Untrained materials; a piece for each."""
    return [(one_finger, (_situation(axes, name, seed), table, axes.times_s)) for name, _ in foreign_materials(axes)]


def foreign_rows(axes: Axes, found: Sequence[list[Answered]]) -> list[dict[str, Any]]:
    """Of the results of `foreign_pieces`; `right` means nothing here, and every `identified` is wrong."""
    rows = []
    for (name, away_ln), answers in zip(foreign_materials(axes), found, strict=True):
        rows += shares(answers, material=name, away_ln=round(away_ln, 3))
    return rows


def default_noise(axes: Axes) -> float:
    """The simulator's own noise has to be among those of the map: other maps use its table."""
    if NOISE_C not in axes.noises_k:
        raise ValueError(f"the noises of a map must have the simulator's own, {NOISE_C} K")
    return NOISE_C


def _situation(axes: Axes, name: str, seed: int, **how: Any) -> Situation:
    return Situation(name, seed, axes.touches, seconds=axes.seconds, **how)


def _cell(found: Sequence[list[Answered]], place: int) -> list[Answered]:
    return [answer for each in found[place * len(FOUR) : (place + 1) * len(FOUR)] for answer in each]
