"""Collects the answers to a touch at each time from exponential fits, from fingers together, and from the product."""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import chain
from typing import NamedTuple

from common.wire.messages import OBJECT_UNKNOWN_SD_K, ThermalStatus
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.shared_object import ONE_OBJECT, SharedObject
from remote_site.thermal.solving_turns import Solver, SolvingTurns
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import NamingRule, ThermalConclusion, ThermalResult
from remote_site.thermal.touch_estimate import TouchEstimate, TouchEvidence
from remote_site.thermal.touch_start import RecordedTouch, reference_touch
from studies.thermal_identification.exponential import RateTable, fits
from studies.thermal_identification.situations import Hand

JUDGED_EVERY = 5
"""Readings between two answers, which come 20 times a second; the evidence of every reading counts."""
READING_S = 0.01
SHIPPED_RULE = NamingRule()
TICKS = 5
"""Ticks of a session from one reading to the next."""


class Answered(NamedTuple):
    """Answer of one method to one touch at one time.

    Attributes:
        method: name of the method.
        truth: true material.
        t_s: time after contact, s.
        best: likeliest material; None without an answer yet.
        probability: probability of `best`, 0..1; None for a method without probabilities.
        status: name of the answer's status; None for a method without statuses.
        error_k: estimated minus true temperature of the object, K; None without an estimate.
        sd_k: claimed standard deviation of the estimate, K.
        named_s: time at which a material was first named, s after contact; None before.
        reason: reason for a missing answer.
        rule: rule by which a material was named, from `by_fingers`; None from all other methods.
    """

    method: str
    truth: str
    t_s: float
    best: str | None
    probability: float | None = None
    status: str | None = None
    error_k: float | None = None
    sd_k: float | None = None
    named_s: float | None = None
    reason: str | None = None
    rule: NamingRule | None = None


@cache
def knowledge_of(table: str) -> ThermalKnowledge:
    """Return the identification's knowledge from a table in JSON, a form that passes between processes."""
    return ThermalKnowledge.of(MaterialTable.model_validate_json(table))


def by_rate(rates: RateTable, hand: Hand) -> list[Answered]:
    """Return the answers of a single exponential fit from the first finger."""
    found = []
    for number, fit in enumerate(fits(rates.way, hand.fingers[0], rates.times_s)):
        error_k = None if fit is None else fit.object_c - hand.object_c
        best = rates.likeliest(number, fit)
        found.append(Answered(rates.way, hand.material, rates.times_s[number], best, error_k=error_k))
    return found


def by_fingers(
    knowledge: ThermalKnowledge,
    hand: Hand,
    groups: Mapping[str, int],
    times_s: Sequence[float],
    rules: Sequence[NamingRule] = (SHIPPED_RULE,),
) -> list[Answered]:
    """Return the answers of the estimator from the first fingers of a hand.

    An unheated sensor beside a finger's own is judged with it, if the touch and the table have one.

    Args:
        knowledge: knowledge from the table.
        hand: the touch.
        groups: number of fingers that each method may use, by the method's name.
        times_s: times of the answers, ascending, s after contact.
        rules: rules by which a material is named; each gives answers of its own.
    """
    fingers = hand.fingers[: max(groups.values())]
    sensors = [_sensors(knowledge, finger) for finger in fingers]
    length = min(sensor.length for each in sensors for sensor in each)
    conclusions = {
        (name, rule): ThermalConclusion(knowledge.table.names(), knowledge.table.plate_j_m2k, rule)
        for name in groups
        for rule in rules
    }
    named: dict[tuple[str, NamingRule], float] = {}
    found = []
    for k in range(1, min(round(times_s[-1] / READING_S) + 1, length)):
        since_s = k * READING_S
        used_s = min(since_s, knowledge.table.lasts_s)
        if used_s == since_s:
            for each in sensors:
                for sensor in each:
                    sensor.take(k)
        if k % JUDGED_EVERY:
            continue
        evidence = [[sensor.evidence(used_s) for sensor in each] for each in sensors]
        wanted = [t_s for t_s in times_s if abs(t_s - since_s) < READING_S / 2]
        for name, count in groups.items():
            posterior = knowledge.posterior.judge(list(chain(*evidence[:count])), compare=count > 1)
            if posterior.same_object < ONE_OBJECT:  # then the first finger answers alone, as in a session
                posterior = knowledge.posterior.judge(evidence[0])
            for rule in rules:
                answer = conclusions[name, rule].step(posterior, since_s)
                if answer.status is ThermalStatus.IDENTIFIED:
                    named.setdefault((name, rule), since_s)
                named_s = named.get((name, rule))
                found += [_answered(name, hand, t_s, answer, named_s)._replace(rule=rule) for t_s in wanted]
    return found


def by_product(
    knowledge: ThermalKnowledge,
    method: str,
    hand: Hand,
    times_s: Sequence[float],
    fingers: int = 1,
    late: bool = False,
) -> list[Answered]:
    """Return the answers of a session's identification, which also detects lost contact and sensor faults.

    Args:
        knowledge: knowledge from the table.
        method: name in the answers.
        hand: the touch.
        times_s: times of the answers, ascending, s after contact.
        fingers: number of fingers used.
        late: whether every tick is late.
    """
    touches = hand.fingers[:fingers]
    identifications = {number: ThermalIdentification(knowledge) for number in range(len(touches))}
    for touch, identification in zip(touches, identifications.values(), strict=True):
        identification.start(0.0, touch.start_c, touch.slope_k_s, touch.ambient_c)
    shared, answer = SharedObject(knowledge), identifications[0].answer
    solvers: list[Solver] = [*identifications.values(), shared]
    tick_s = READING_S / TICKS
    turns = SolvingTurns(0.0 if late else tick_s)
    named: float | None = None
    found: list[Answered] = []
    for readings in zip(*(list(touch.readings())[1:] for touch in touches), strict=False):
        since_s = readings[0][0]
        while len(found) < len(times_s) and since_s > times_s[len(found)] + 1e-6:
            found.append(_answered(method, hand, times_s[len(found)], answer, named))
        for (_, sensor_c, force_n), identification in zip(readings, identifications.values(), strict=True):
            identification.take(since_s, sensor_c, force_n)
        for tick in range(TICKS):
            together = shared.look(identifications)
            for identification in identifications.values():
                identification.alone = together is None
            if (solver := turns.step(since_s + tick * tick_s, solvers)) is not None:
                solver.work()
        answer = together or identifications[0].answer
        if named is None and answer.status is ThermalStatus.IDENTIFIED:
            named = since_s
    while len(found) < len(times_s):
        found.append(_answered(method, hand, times_s[len(found)], answer, named))
    return found


class _Sensor:
    """The running estimate of one sensor's touch."""

    def __init__(
        self, knowledge: ThermalKnowledge, touch: RecordedTouch, beside: ThermalKnowledge | None = None
    ) -> None:
        """Begin at contact; `beside` is the knowledge of the heated sensor, if this is the unheated one beside it."""
        self._knowledge, self._beside = knowledge, beside
        ambient_c = knowledge.table.ambient_c if touch.ambient_c is None else touch.ambient_c
        self._estimate = TouchEstimate(
            knowledge.table, knowledge.substances, knowledge.guesses, touch.start_c, touch.slope_k_s, ambient_c
        )
        self._readings = list(touch.readings())

    @property
    def length(self) -> int:
        """Number of readings from contact on."""
        return len(self._readings)

    def take(self, k: int) -> None:
        """Take reading k, and do the work of a session until the next one."""
        (before_s, _, _), (since_s, sensor_c, force_n) = self._readings[k - 1 : k + 1]
        self._estimate.take(since_s - before_s, sensor_c, force_n)
        for _ in range(TICKS):
            self._estimate.work()

    def evidence(self, since_s: float) -> TouchEvidence:
        """Return the evidence at `since_s` seconds after contact, as the heated sensor can use it."""
        found = self._knowledge.corrected(self._estimate.evidence(), since_s)
        return found if self._beside is None else self._beside.posterior.beside(found)


def _sensors(knowledge: ThermalKnowledge, touch: RecordedTouch) -> list[_Sensor]:
    found = [_Sensor(knowledge, touch)]
    if knowledge.reference is not None and touch.trace.reference_c is not None:
        found.append(_Sensor(knowledge.reference, reference_touch(touch), knowledge))
    return found


def _answered(method: str, hand: Hand, t_s: float, answer: ThermalResult, named_s: float | None) -> Answered:
    object_c = None if answer.object_c_sd == OBJECT_UNKNOWN_SD_K else answer.object_c
    return Answered(
        method,
        hand.material,
        t_s,
        answer.best,
        answer.probability,
        answer.status.name.lower(),
        None if object_c is None else object_c - hand.object_c,
        None if object_c is None else answer.object_c_sd,
        named_s,
        answer.reason.code or None,
    )
