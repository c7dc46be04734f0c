"""Learns from labelled touches how far the estimates of a sensor are from the truth; see `discrepancy`."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar

from common.runtime.parallel_map import Map
from remote_site.thermal.discrepancy import BY_TIME, Discrepancy
from remote_site.thermal.evidence_correction import EvidenceCorrection
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_identification import (
    HALF_READING_S,
    ThermalIdentification,
    ThermalKnowledge,
    knowledge_of,
)
from remote_site.thermal.touch_estimate import TouchEvidence
from remote_site.thermal.touch_start import RecordedTouch

Array = NDArray[np.float64]

TIMES_S = (0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0)
"""Times after contact at which the discrepancy is learned, s."""
PLATE_SD, OBJECT_SD = 0.03, 0.15
"""Prior standard deviations of the errors by plate and by object."""
STATED_LN_SD = 0.75
"""Prior standard deviation of ln(true over stated standard deviation)."""
LEAST_STATED, MOST_STATED = 0.3, 3.0
"""Range of the true over the stated standard deviation."""
SHARPNESS_LN_SD = 1.0
"""Prior standard deviation of ln sharpness."""
LEAST_SHARPNESS, MOST_SHARPNESS = 0.05, 1.5
"""Range of the sharpness."""
UNKNOWN_SPREAD = 0.05
"""Spread where the temperatures of the objects are not known, from kinds of sensors whose objects are."""
ROUNDS = 10
"""Rounds between the errors and their variances."""
EARLY_END = "contact is lost, or readings are missing or stuck"
"""Reasons why a touch ends before its trace."""
LEAST_BY_OBJECT = -0.9
"""Least error by object; at -1 the estimate would not depend on the object."""
_SETTLED = 0.02
"""Change of a logarithm of a variance in a round below which the fit has settled."""
_SEARCH = {"maxiter": 200}
_LN_RANGE = (2.0 * np.log((LEAST_STATED, 1e-4)), 2.0 * np.log((MOST_STATED, 1.0)))
_LEAST_LEFT = 0.3
"""Least part of a residual's variance that the fit of its material has left."""


class Labelled(NamedTuple):
    """A touch with its material's index and its object's temperature, C, or None if unknown."""

    touch: RecordedTouch
    material: int
    object_c: float | None


@dataclass(frozen=True, slots=True)
class Seen:
    """Evidence of one touch at one time, and the truth; `number` is the touch's place in its list."""

    evidence: TouchEvidence
    material: int
    object_c: float | None
    number: int = 0


def evidence_course(table: str, times_s: Sequence[float], touch: RecordedTouch) -> list[TouchEvidence | None]:
    """Return the evidence of a touch at ascending times after contact, s; None where the touch was over.

    The table is JSON, a form that passes between processes.
    """
    identification = ThermalIdentification(knowledge_of(table))
    identification.start(0.0, touch.start_c, touch.slope_k_s, touch.ambient_c)
    readings = list(touch.readings())[1:]  # the reading at contact is where the touch starts
    found: list[TouchEvidence | None] = []
    for since_s, sensor_c, force_n in readings:
        identification.step(since_s, sensor_c, force_n)
        while len(found) < len(times_s) and since_s > times_s[len(found)] - HALF_READING_S:
            found.append(identification.evidence())
        if not identification.running:
            break
    return found + [None] * (len(times_s) - len(found))


def courses(table: MaterialTable, labelled: Sequence[Labelled], mapped: Map) -> dict[float, list[Seen]]:
    """Return the evidence of all touches by time, without times that the table does not reach.

    Args:
        table: the table. Its discrepancy does not correct the evidence, but its times count if it has one.
        labelled: the touches.
        mapped: the function `map`, or a parallel one.

    Raises:
        ValueError: no touch gives any evidence.
    """
    wanted_s = TIMES_S if table.discrepancy is None else table.discrepancy.times_s
    times_s = [t_s for t_s in wanted_s if t_s <= table.lasts_s + 1e-6]
    plain = table.model_copy(update={"discrepancy": None, "reference": None})
    work = partial(evidence_course, plain.model_dump_json(), times_s)
    found: dict[float, list[Seen]] = {t_s: [] for t_s in times_s}
    all_courses = mapped(work, [each.touch for each in labelled])
    for number, (each, course) in enumerate(zip(labelled, all_courses, strict=True)):
        for t_s, evidence in zip(times_s, course, strict=True):
            if evidence is not None:
                found[t_s].append(Seen(evidence, each.material, each.object_c, number))
    if not any(found.values()):
        raise ValueError(f"no touch lasts {times_s[0]:g} s: {EARLY_END}")
    return {t_s: seen for t_s, seen in found.items() if seen}


def learn(table: MaterialTable, seen: dict[float, list[Seen]]) -> Discrepancy:
    """Return the discrepancy that the evidence shows.

    A material without evidence, or whose objects have no known temperature, gets no errors, but the spread
    UNKNOWN_SPREAD. Of a table that has a discrepancy, only the temperature errors of the touched materials are learned
    again.

    Args:
        table: the table.
        seen: evidence of the touches by time, from `courses`; all objects are known if the table has a discrepancy.
    """
    if table.discrepancy is not None:
        return _learn_temperature(table.discrepancy, seen)
    materials = len(table.materials)
    everyone = [one for each in seen.values() for one in each]
    objects_c = [[one.object_c for one in everyone if one.material == number] for number in range(materials)]
    known = [bool(mine_c) and None not in mine_c for mine_c in objects_c]
    conditions = [_conditions(everyone, number) for number in range(materials)]
    where = {name: [getattr(each, name) for each in conditions] for name in _Conditions._fields}
    plain = ThermalKnowledge.of(table)
    rows = []
    for t_s, each in seen.items():
        found = _errors([one for one in each if known[one.material]], materials)
        row = Discrepancy(
            times_s=[t_s],
            by_plate=[found.by_plate.tolist()],
            by_object=[found.by_object.tolist()],
            by_object_sd=[found.by_object_sd.tolist()],
            spread=[np.where(known, found.spread, UNKNOWN_SPREAD).tolist()],
            stated_sd=[found.stated_sd],
            sharpness=[1.0],
            known_objects=known,
            **where,
        )
        rows.append(row.model_copy(update={"sharpness": [_sharpness(plain, row, each)]}))
    return Discrepancy(
        known_objects=known,
        **where,
        **{name: [getattr(row, name)[0] for row in rows] for name in BY_TIME},
    )


def _learn_temperature(before: Discrepancy, seen: dict[float, list[Seen]]) -> Discrepancy:
    """Return a discrepancy with other temperature errors of the touched materials.

    `stated_sd` is common to all materials. It stays if another material's errors depend on it.
    """
    everyone = [one for each in seen.values() for one in each]
    touched = {one.material for one in everyone}
    known = [number in touched or was for number, was in enumerate(before.known_objects)]
    alone = not any(was and number not in touched for number, was in enumerate(before.known_objects))
    found = before.model_dump() | {"known_objects": known}
    for number in touched:
        for name, value in _conditions(everyone, number)._asdict().items():
            found[name][number] = value
    for k, t_s in enumerate(before.times_s):
        each = seen.get(t_s, [])
        errors = _errors(each, len(known), None if alone else before.stated_sd[k])
        for number in {one.material for one in each}:
            found["by_plate"][k][number] = float(errors.by_plate[number])
            found["by_object"][k][number] = float(errors.by_object[number])
            found["by_object_sd"][k][number] = float(errors.by_object_sd[number])
            found["spread"][k][number] = errors.spread
        if alone and each:
            found["stated_sd"][k] = errors.stated_sd
    return Discrepancy.model_validate(found)


class _Conditions(NamedTuple):
    """Temperatures of plate and objects of a material, K above ambient, 0 where unknown; see `Discrepancy`."""

    plate_k: float
    coldest_k: float
    warmest_k: float


def _conditions(everyone: Sequence[Seen], material: int) -> _Conditions:
    mine = [one for one in everyone if one.material == material]
    plates_k = [one.evidence.start_c - one.evidence.ambient_c for one in mine]
    objects_k = [one.object_c - one.evidence.ambient_c for one in mine if one.object_c is not None]
    return _Conditions(
        float(np.mean(plates_k)) if mine else 0.0, min(objects_k, default=0.0), max(objects_k, default=0.0)
    )


class _Errors(NamedTuple):
    """Errors of the temperature at one time; see `Discrepancy`."""

    by_plate: Array
    by_object: Array
    by_object_sd: Array
    spread: float
    stated_sd: float


def _errors(each: Sequence[Seen], materials: int, stated_sd: float | None = None) -> _Errors:
    """Fit the errors of each material and their common variance in turn; `stated_sd` is fitted if it is None."""
    factors, by_object_sd = np.zeros((materials, 2)), np.full(materials, OBJECT_SD)
    if not each:
        return _Errors(factors[:, 0], factors[:, 1], by_object_sd, 0.0, 1.0)
    material = np.array([one.material for one in each])
    objects_k = np.array([(one.object_c or 0.0) - one.evidence.ambient_c for one in each])
    plates_k = np.array([one.evidence.start_c - one.evidence.ambient_c for one in each])
    errors_k = np.array([one.evidence.mean[one.material, 0] for one in each]) - objects_k
    stated = np.array([one.evidence.covariance[one.material, 0, 0] for one in each])
    differs = (plates_k - objects_k) ** 2
    columns = np.stack((plates_k, objects_k), axis=1)
    prior = np.diag((PLATE_SD**-2, OBJECT_SD**-2))
    ln = np.array([0.0 if stated_sd is None else 2.0 * np.log(stated_sd), np.log(1e-5)])
    """ln of the variance over the stated one, and of the spread's square."""
    fixed = 0 if stated_sd is None else 1
    for _ in range(ROUNDS):
        weight = 1.0 / (np.exp(ln[0]) * stated + np.exp(ln[1]) * differs)
        left = np.ones(len(each))
        for number in range(materials):
            mine = material == number
            x, w = columns[mine], weight[mine]
            covariance = np.linalg.inv(np.einsum("ni,n,nj->ij", x, w, x) + prior)
            by_object_sd[number] = np.sqrt(covariance[1, 1])
            factors[number] = covariance @ np.einsum("ni,n,n->i", x, w, errors_k[mine])
            left[mine] -= w * np.einsum("ni,ij,nj->n", x, covariance, x)
        rest = (errors_k - np.einsum("ni,ni->n", columns, factors[material])) ** 2 / np.maximum(left, _LEAST_LEFT)
        arguments = (ln[:fixed], rest, stated, differs)
        free = minimize(_unlikely, ln[fixed:], arguments, "Nelder-Mead", options=_SEARCH).x
        before, ln = ln, np.clip(np.append(ln[:fixed], free), *_LN_RANGE)
        if np.abs(ln - before).max() < _SETTLED:
            break
    spread, stated_sd = float(np.exp(0.5 * ln[1])), float(np.exp(0.5 * ln[0]))
    return _Errors(factors[:, 0], np.maximum(factors[:, 1], LEAST_BY_OBJECT), by_object_sd, spread, stated_sd)


def _unlikely(free: Array, fixed: Array, rest: Array, stated: Array, differs: Array) -> float:
    """Return twice the negative ln probability of squared errors `rest`, K^2, up to a constant."""
    ln = np.append(fixed, free)
    variance = np.exp(ln[0]) * stated + np.exp(ln[1]) * differs
    return float(np.sum(np.log(variance) + rest / variance) + (0.5 * ln[0] / STATED_LN_SD) ** 2)


def _sharpness(knowledge: ThermalKnowledge, discrepancy: Discrepancy, each: Sequence[Seen]) -> float:
    """Return the exponent of the likelihood with the best ln score of the true materials."""
    t_s = discrepancy.times_s[0]

    def cost(ln_sharpness: float) -> float:
        tried = discrepancy.model_copy(update={"sharpness": [float(np.exp(ln_sharpness))]})
        correction = EvidenceCorrection(tried, knowledge.substances.ln_effusivity)
        score = 0.0
        for one in each:
            posterior = knowledge.posterior.judge([correction.corrected(one.evidence, t_s)])
            score += float(np.log(max(posterior.probability[one.material], 1e-9)))
        return 0.5 * (ln_sharpness / SHARPNESS_LN_SD) ** 2 - score

    bounds = (np.log(LEAST_SHARPNESS), np.log(MOST_SHARPNESS))
    return float(np.exp(minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 0.1}).x))
