"""Pieces of work of the study of thermal identification; each simulates its own touches."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from studies.thermal_identification.answers import Answered, by_fingers, by_product, by_rate, knowledge_of
from studies.thermal_identification.exponential import WAYS, RateTable
from studies.thermal_identification.reference import Reference, features
from studies.thermal_identification.situations import (
    AMBIENT_C,
    Hand,
    Situation,
    calibrated,
    calibration_touches,
    noisier,
    touched,
)

Array = NDArray[np.float64]

ONE = "1 finger"


class Examples(NamedTuple):
    """Examples for the reference: features by time after contact, materials, and temperatures above ambient, K."""

    rows: dict[float, Array]
    materials: list[str]
    above_k: list[float]

    @classmethod
    def of(cls, hands: Sequence[Hand], fingers: int, times_s: Sequence[float]) -> "Examples":
        """Build examples from touches."""
        return cls(
            {t_s: features(hands, fingers, t_s) for t_s in times_s},
            [hand.material for hand in hands],
            [hand.object_c - AMBIENT_C for hand in hands],
        )

    @classmethod
    def together(cls, parts: "Sequence[Examples]") -> "Examples":
        """Join examples that have the same times."""
        return cls(
            {t_s: np.concatenate([part.rows[t_s] for part in parts]) for t_s in parts[0].rows},
            [material for part in parts for material in part.materials],
            [above_k for part in parts for above_k in part.above_k],
        )

    def part(self, fingers: int, t_s: float) -> "Examples":
        """Return the examples of the first fingers at one time."""
        return self._replace(rows={t_s: self.rows[t_s][:, :fingers]})


class Calibration(NamedTuple):
    """Result of a calibration: the table as JSON, and the rates of each exponential fit."""

    table: str
    rates: tuple[RateTable, ...]


def calibrate(
    materials: Sequence[str], touches: int, seed: int, noise_k: float, seconds: float, times_s: Sequence[float]
) -> Calibration:
    """Calibrate with a number of touches of each material, `seconds` each; no rates if `times_s` is empty."""
    hands = calibration_touches(materials, touches, seed, noise_k, seconds)
    rates = tuple(RateTable.of(way, hands, times_s) for way in WAYS) if times_s else ()
    return Calibration(calibrated(hands).model_dump_json(), rates)


def examples(situation: Situation, times_s: Sequence[float]) -> Examples:
    """Return examples for training."""
    return Examples.of(touched(situation), len(situation.preheats_k), times_s)


def examine(
    situation: Situation,
    calibration: Calibration,
    groups: Mapping[str, int],
    times_s: Sequence[float],
    learned: tuple[int, Sequence[float]],
) -> tuple[list[Answered], Examples]:
    """Return the estimator's answers to new touches, those by rate if there are rates, and the reference's examples.

    `learned` holds the reference's number of fingers and its times.
    """
    hands, knowledge = touched(situation), knowledge_of(calibration.table)
    answers = [answer for hand in hands for answer in by_fingers(knowledge, hand, groups, times_s)]
    answers += [answer for rates in calibration.rates for hand in hands for answer in by_rate(rates, hand)]
    return answers, Examples.of(hands, *learned)


def by_reference(reference: Reference, method: str, tested: Examples, t_s: float) -> list[Answered]:
    """Return the reference's answers."""
    probability, above_k, sd_k = reference.judge(tested.rows[t_s])
    return [
        Answered(
            method,
            tested.materials[one],
            t_s,
            reference.names[int(np.argmax(probability[one]))],
            float(probability[one].max()),
            error_k=float(above_k[one]) - tested.above_k[one],
            sd_k=float(sd_k[one]),
        )
        for one in range(len(tested.materials))
    ]


def with_noise(situation: Situation, tables: Mapping[float, str], times_s: Sequence[float]) -> list[list[Answered]]:
    """Return answers to the same touches with several noises, K, each with the table of a sensor of that noise."""
    hands = touched(situation)
    return [
        [
            answer
            for hand in noisier(hands, noise_k, situation.seed)
            for answer in by_fingers(knowledge_of(table), hand, {ONE: 1}, times_s)
        ]
        for noise_k, table in tables.items()
    ]


def in_session(situation: Situation, table: str, times_s: Sequence[float]) -> list[list[Answered]]:
    """Return the answers of the product's whole identification, which detects changes of contact, to one finger."""
    knowledge = knowledge_of(table)
    return [[answer for hand in touched(situation) for answer in by_product(knowledge, ONE, hand, times_s)]]
