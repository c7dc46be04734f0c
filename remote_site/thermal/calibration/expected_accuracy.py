"""Predicts the accuracy of a calibrated table: touches are judged with a discrepancy learned without them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from remote_site.thermal.calibration.discrepancy_fit import Seen, learn
from remote_site.thermal.discrepancy import BY_TIME
from remote_site.thermal.evidence_correction import EvidenceCorrection
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.touch_estimate import TouchEvidence

TIMES_S = (1.0, 2.0, 3.0, 5.0)
"""Times after contact for which the accuracy is predicted, s."""
FOLDS = 5
"""Number of parts of the touches; each is judged with what the others teach."""


@dataclass(frozen=True, slots=True)
class Judged:
    """Answer of one finger or two fingers, and the truth.

    Attributes:
        fingers: number of fingers.
        t_s: time after contact, s.
        material: index of the true material.
        right: whether it is the likeliest.
        probability: stated probability of the likeliest material, 0..1.
        error_k: estimated minus true temperature of the object, K; None if the truth is unknown.
        sd_k: stated standard deviation of the temperature, K.
    """

    fingers: int
    t_s: float
    material: int
    right: bool
    probability: float
    error_k: float | None
    sd_k: float


def judge_in_folds(before: MaterialTable, seen: dict[float, list[Seen]]) -> list[Judged]:
    """Judge each touch with a discrepancy learned from the other folds; `before` is the table before it was learned.

    The populations stay, although they were fitted to the same touches. Two touches of one material are moved to a
    common object temperature and judged as two fingers. Errors that fingers of one hand share are missing from this.
    """
    judged_s = [t_s for t_s in TIMES_S if t_s in seen]
    parts = {t_s: seen[t_s] for t_s in judged_s}
    fold = _folds(parts)
    knowledge = ThermalKnowledge.of(before)
    found: list[Judged] = []
    for number in range(FOLDS):
        others = {t_s: [one for one in each if fold[one.number] != number] for t_s, each in parts.items()}
        if not all(others.values()):
            continue
        learned = learn(_at_times(before, judged_s), others)
        correction = EvidenceCorrection(learned, knowledge.substances.ln_effusivity)
        for t_s, each in parts.items():
            corrected = [
                replace(one, evidence=correction.corrected(one.evidence, t_s))
                for one in each
                if fold[one.number] == number
            ]
            found += [_judge(knowledge, t_s, one, [one.evidence]) for one in corrected]
            found += [_judge(knowledge, t_s, one, pair) for one, pair in _pairs(corrected)]
    return found


def _folds(parts: dict[float, list[Seen]]) -> dict[int, int]:
    """Return the fold of each touch, by its number; each material is spread evenly."""
    material = {one.number: one.material for each in parts.values() for one in each}
    fold, count = {}, dict.fromkeys(material.values(), 0)
    for number in sorted(material):
        fold[number] = count[material[number]] % FOLDS
        count[material[number]] += 1
    return fold


def _at_times(table: MaterialTable, times_s: Sequence[float]) -> MaterialTable:
    """Return the table with only these times of its discrepancy, if it has one."""
    whole = table.discrepancy
    if whole is None:
        return table
    at = [whole.times_s.index(t_s) for t_s in times_s]
    part = {name: [getattr(whole, name)[k] for k in at] for name in BY_TIME}
    return table.model_copy(update={"discrepancy": whole.model_copy(update=part)})


def _pairs(each: list[Seen]) -> Iterator[tuple[Seen, list[TouchEvidence]]]:
    """Yield pairs of touches of one material as if both were on the object of the first."""
    for one, other in pairwise(sorted(each, key=lambda one: one.material)):
        if one.material == other.material and one.object_c is not None and other.object_c is not None:
            yield one, [one.evidence, _moved(other.evidence, other.object_c, one.evidence, one.object_c)]


def _moved(touch: TouchEvidence, object_c: float, to: TouchEvidence, to_object_c: float) -> TouchEvidence:
    """Return evidence as from an object of another temperature; its errors stay."""
    mean = touch.mean.copy()
    mean[:, 0] += (to_object_c - to.ambient_c) - (object_c - touch.ambient_c)
    return replace(touch, mean=mean, ambient_c=to.ambient_c, start_c=touch.start_c + to_object_c - object_c)


def _judge(knowledge: ThermalKnowledge, t_s: float, one: Seen, touches: list[TouchEvidence]) -> Judged:
    posterior = knowledge.posterior.judge(touches, compare=False)
    best = int(posterior.probability.argmax())
    return Judged(
        fingers=len(touches),
        t_s=t_s,
        material=one.material,
        right=best == one.material,
        probability=float(posterior.probability[best]),
        error_k=None if one.object_c is None else posterior.object_c - one.object_c,
        sd_k=posterior.object_c_sd,
    )
