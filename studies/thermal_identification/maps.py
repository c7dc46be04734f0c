"""Maps the failures of identification: small difference, noise, lost contact, scattering contacts, foreign materials.

Each map has a list of pieces over its varied conditions, and rows made of their answers.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from common.scenes.materials import material, materials
from sim_sensors.physics.ssr_converter import NOISE_C
from studies.pieces import Piece
from studies.thermal_identification.answers import Answered
from studies.thermal_identification.pieces import in_session, one_finger, with_noise
from studies.thermal_identification.shares import shares
from studies.thermal_identification.situations import FOUR, PREHEAT_K, SECONDS, Situation

FAR_LN = 0.5
"""Distance in ln effusivity from every calibrated material at which a foreign material must be distinguished."""


@dataclass(frozen=True, slots=True)
class Axes:
    """Axes of the maps.

    Attributes:
        differences_k: plate minus object at contact, K; the plate has its usual pre-heat, and the object varies.
        noises_k: standard deviation of a reading, K.
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


def difference_pieces(axes: Axes, tables: dict[float, str], seed: int) -> list[Piece]:
    """Return pieces over difference x noise x time, one for each difference and material."""
    return [
        (with_noise, (_situation(axes, name, seed, offset_c=(above_k, above_k)), tables, axes.times_s))
        for above_k in (PREHEAT_K - difference_k for difference_k in axes.differences_k)
        for name in FOUR
    ]


def difference_rows(axes: Axes, found: Sequence[list[tuple[float, list[Answered]]]]) -> list[dict[str, Any]]:
    """Return the rows from the results of `difference_pieces`."""
    rows = []
    for place, difference_k in enumerate(axes.differences_k):
        cell = found[place * len(FOUR) : (place + 1) * len(FOUR)]
        for number, noise_k in enumerate(axes.noises_k):
            answers = [answer for each in cell for answer in each[number][1]]
            rows += shares(answers, difference_k=difference_k, noise_k=noise_k)
    return rows


def change_pieces(axes: Axes, table: str, seed: int) -> list[Piece]:
    """Return pieces with a lost or changed contact, one for each change and material."""
    return [
        (in_session, (_situation(axes, name, seed, later=change), table, axes.times_s))
        for change in axes.changes
        for name in FOUR
    ]


def change_rows(axes: Axes, found: Sequence[list[Answered]]) -> list[dict[str, Any]]:
    """Return the rows from the results of `change_pieces`."""
    rows = []
    for place, (at_s, share) in enumerate(axes.changes):
        rows += shares(_cell(found, place), change_s=at_s, force_share=share)
    return rows


def spread_pieces(axes: Axes, table: str, seed: int) -> list[Piece]:
    """Return pieces with another scatter of contacts than in calibration, one for each spread and material."""
    return [
        (one_finger, (_situation(axes, name, seed, contact_spread=spread), table, axes.times_s))
        for spread in axes.spreads
        for name in FOUR
    ]


def spread_rows(axes: Axes, found: Sequence[list[Answered]]) -> list[dict[str, Any]]:
    """Return the rows from the results of `spread_pieces`."""
    rows = []
    for place, spread in enumerate(axes.spreads):
        rows += shares(_cell(found, place), contact_spread=spread)
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


def foreign_pieces(axes: Axes, table: str, seed: int) -> list[Piece]:
    """Return pieces with uncalibrated materials, one for each."""
    return [(one_finger, (_situation(axes, name, seed), table, axes.times_s)) for name, _ in foreign_materials(axes)]


def foreign_rows(axes: Axes, found: Sequence[list[Answered]]) -> list[dict[str, Any]]:
    """Return the rows from the results of `foreign_pieces`; every `identified` is wrong, and `right` has no meaning."""
    rows = []
    for (name, away_ln), answers in zip(foreign_materials(axes), found, strict=True):
        rows += shares(answers, material=name, away_ln=round(away_ln, 3))
    return rows


def default_noise(axes: Axes) -> float:
    """Return the simulator's own noise, K; raise ValueError if the map lacks it, because other maps use its table."""
    if NOISE_C not in axes.noises_k:
        raise ValueError(f"the noises of a map must include the simulator's own, {NOISE_C} K")
    return NOISE_C


def _situation(axes: Axes, name: str, seed: int, **how: Any) -> Situation:
    return Situation(name, seed, axes.touches, seconds=axes.seconds, **how)


def _cell(found: Sequence[list[Answered]], place: int) -> list[Answered]:
    return [answer for each in found[place * len(FOUR) : (place + 1) * len(FOUR)] for answer in each]
