"""Thermal identification of one finger's touches: material and object temperature, improving with every reading.

Two methods run on the same readings: the paper's (Eq. 7-11: rate of the exponential response, likeliest calibrated
rate) and the model of the touch (`touch_estimate`), which alone decides the status.
"""

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Self

import numpy as np

from common.exploration.contact_detector import CONTACT_OFF_N
from common.wire.messages import ThermalReason, ThermalStatus
from remote_site.thermal.contact_change import NEARLY_S
from remote_site.thermal.evidence_correction import EvidenceCorrection
from remote_site.thermal.exponential_response import ExponentialFit, ExponentialResponse
from remote_site.thermal.material_posterior import MaterialPosterior
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.solving_turns import NOTHING_DUE
from remote_site.thermal.thermal_result import (
    LATEST_S,
    NO_CONTACT,
    NOT_RENDERED,
    ThermalConclusion,
    ThermalResult,
    undecided,
)
from remote_site.thermal.touch_estimate import SOLVE_EVERY_S, Intervals, TouchEstimate, TouchEvidence, last_solution_s
from remote_site.thermal.touch_hypotheses import FOREIGN, Substances, TouchHypotheses, guesses, substances

SENSOR_FAULTS = (
    ThermalReason.NOT_A_NUMBER,
    ThermalReason.READING_STUCK,
    ThermalReason.SENSOR_SHORTED,
    ThermalReason.SENSOR_OPEN,
    ThermalReason.SENSOR_JUMPS,
    ThermalReason.SENSOR_FROZEN,
)
"""Ends of a touch after which its readings do not count for the other fingers: some came before the fault was found."""
ANSWERED = (ThermalStatus.IDENTIFIED, ThermalStatus.AMBIGUOUS, ThermalStatus.UNKNOWN)
LEAST_RATE_SD = 0.02
"""Minimum scatter of ln(rate) between touches of one material."""
LOST_S = 0.05
"""Minimum time without force that ends a contact, s."""
LANDING_S = 1.0
"""Time after contact in which a finger may bounce, s."""
BOUNCE_S = 0.5
"""Minimum time without force that ends a contact if it begins within LANDING_S, s."""
GAP_S = 0.15
"""Maximum time between two readings of a touch, s."""
FLAT_S = 0.75
"""Maximum time for which a plate in contact can repeat the same reading, s."""
AT_REST_K_S = 2.0
"""Maximum slope of a plate at rest, K/s; the model starts from a plate at rest."""
HALF_READING_S = 0.005
"""Half of the interval between two readings, s."""
FIT_EVERY_S = 0.05
"""Interval between two fits of Eq. 11, s."""


@dataclass(frozen=True, slots=True)
class ThermalKnowledge:
    """A table prepared for identification; all fingers share it, and it holds no state of a touch."""

    table: MaterialTable
    substances: Substances
    guesses: TouchHypotheses
    posterior: MaterialPosterior
    at_once: int | None = None
    solve_every_s: Intervals = SOLVE_EVERY_S
    """See `TouchEstimate`."""
    correction: EvidenceCorrection | None = None
    """Correction of what the model leaves out; None for a table that does not know it."""
    reference: "ThermalKnowledge | None" = None
    """Knowledge of the unheated sensor beside this one."""

    @classmethod
    def of(
        cls,
        table: MaterialTable,
        at_once: int | None = None,
        foreign_share: float = FOREIGN,
    ) -> Self:
        """Prepare `table`; `foreign_share` is the prior probability of an object of no calibrated material."""
        known = substances(table, foreign_share)
        reference = None if table.reference is None else cls.of(table.reference, at_once, foreign_share)
        posterior = MaterialPosterior(table, known)
        correction = None
        if table.discrepancy is not None:
            correction = EvidenceCorrection(table.discrepancy, known.ln_effusivity)
        return cls(table, known, guesses(table), posterior, at_once, correction=correction, reference=reference)

    def corrected(self, evidence: TouchEvidence, since_s: float) -> TouchEvidence:
        """Return the evidence of a touch, `since_s` seconds after contact, without the discrepancy of the sensor."""
        return evidence if self.correction is None else self.correction.corrected(evidence, since_s)

    def conclusion(self) -> ThermalConclusion:
        """Return the conclusion of a touch that begins."""
        latest_s = min(LATEST_S, self.last_s)
        return ThermalConclusion(self.table.names(), self.table.plate_j_m2k, latest_s=latest_s)

    @property
    def last_s(self) -> float:
        """Time of a touch's last solution, s after contact."""
        return last_solution_s(self.table.lasts_s, self.solve_every_s)


@lru_cache(1)
def knowledge_of(table: str) -> ThermalKnowledge:
    """Return the knowledge of a table in JSON, a form that passes between processes; that of the last table is kept."""
    return ThermalKnowledge.of(MaterialTable.model_validate_json(table))


class ThermalIdentification:
    """Identification of one finger, one touch after another.

    Attributes:
        answer: present estimates of the touch.
        rested: whether the plate was nearly at rest at contact.
        warmed: whether an earlier touch has left warmth at the spot, so that its temperature is not the object's.
        alone: whether this finger is judged alone instead of by a joint judgement of several fingers.
        since_s: time since contact, s; 0 before the first reading.
        waited_s: time since a solution, or a new sum of earlier readings, became due, s; negative if none is due.
        fresh: whether the touch was solved since this was last set to False.
    """

    def __init__(self, knowledge: ThermalKnowledge) -> None:
        self._knowledge = knowledge
        table = knowledge.table
        self._names = table.names()
        self._prior = dict(zip(self._names, knowledge.substances.probability.tolist(), strict=False))
        self._times_s = np.array(table.times_s)
        self._ln_rates = np.array([entry.ln_rate for entry in table.materials])
        self._ln_rate_sds = np.maximum([entry.ln_rate_sd for entry in table.materials], LEAST_RATE_SD)
        self.answer = NO_CONTACT
        self.alone = True
        self.rested = True
        self.warmed = False
        self.since_s = 0.0
        self.waited_s = NOTHING_DUE
        self.fresh = False
        self._estimate: TouchEstimate | None = None
        self._running = False

    @property
    def touching(self) -> bool:
        """Whether there is a touch; it may take no readings."""
        return self.answer is not NO_CONTACT

    @property
    def running(self) -> bool:
        """Whether the touch still takes readings."""
        return self._running

    def evidence(self) -> TouchEvidence | None:
        """Return the evidence of this touch; None if it is too early, without force, or of a faulty sensor."""
        if self._estimate is None or self._light_since_s is not None or not self._estimate.settled:
            return None
        return self._knowledge.corrected(self._estimate.evidence(), self.since_s)

    def start(
        self,
        t_s: float,
        start_c: float,
        slope_k_s: float,
        ambient_c: float | None,
        back_k: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Begin a touch.

        Args:
            t_s: time of contact, s.
            start_c: reading at contact, C; ideally the mean of the last readings before it.
            slope_k_s: slope of the reading at contact, K/s; the plate is ahead of its reading.
            ambient_c: ambient temperature, C; None for that of the calibration.
            back_k: temperature of the sensor's back above that in calibration, and its standard deviation, K.
        """
        knowledge = self._knowledge
        ambient_c = knowledge.table.ambient_c if ambient_c is None else ambient_c
        self.warmed = False
        self.rested = abs(slope_k_s) <= AT_REST_K_S
        self._estimate = None  # `work` creates it, because the tick of a contact is long already
        self._unread: list[tuple[float, float, float]] = []
        """Readings before the estimate was created."""
        self._begin = partial(
            TouchEstimate,
            knowledge.table,
            knowledge.substances,
            knowledge.guesses,
            start_c,
            slope_k_s,
            ambient_c,
            back_k,
            knowledge.at_once,
            knowledge.solve_every_s,
        )
        self._conclusion = knowledge.conclusion()
        self._exponential = ExponentialResponse(start_c)
        self._fit: ExponentialFit | None = None
        self._fitted_s = 0.0
        self._contact_s = self._before_s = self._changed_s = t_s
        self._before_c: float | None = None
        self._light_since_s: float | None = None
        self.since_s = 0.0
        self.alone = self._running = True
        self.waited_s, self.fresh = NOTHING_DUE, False
        self.answer = undecided(self._prior)

    def step(self, t_s: float, sensor_c: float, force_n: float) -> ThermalResult:
        """Take one reading during a touch, do the due work, and return the answer; see `take`."""
        self.take(t_s, sensor_c, force_n)
        self.work()
        return self.answer

    def take(self, t_s: float, sensor_c: float, force_n: float) -> None:
        """Take one reading during a touch, for `work`.

        Args:
            t_s: time, s.
            sensor_c: reading, C.
            force_n: contact force, N; below the contact threshold the touch ends.
        """
        if not self._running:
            return
        if not force_n >= CONTACT_OFF_N:
            if self._light_since_s is None:
                self._light_since_s = t_s
            landing = self._light_since_s - self._contact_s < LANDING_S
            if t_s - self._light_since_s >= (BOUNCE_S if landing else LOST_S):
                self.stop(ThermalReason.CONTACT_LOST)
            if not landing or not self._running:
                return
        else:
            self._light_since_s = None
        dt_s = t_s - self._before_s
        fault = self._fault(t_s, dt_s, sensor_c)
        if fault:
            self.stop(fault)
        elif dt_s > 0.0:
            self._before_s, self.since_s = t_s, t_s - self._contact_s
            self._exponential.add(self.since_s, sensor_c)
            if (estimate := self._estimate) is None:
                self._unread.append((dt_s, sensor_c, force_n))
                self.waited_s = self.since_s
            else:
                estimate.take(dt_s, sensor_c, force_n)
                self._update_due(estimate)

    def work(self) -> None:
        """Do the due slow work, if any: a part of a solution, or of a new sum of earlier readings."""
        if self.waited_s < 0.0:
            return
        if self._estimate is None:
            self._estimate = self._begin()
            for reading in self._unread:
                self._estimate.take(*reading)
            self._update_due(self._estimate)
            if self.waited_s < 0.0:
                return
        self._estimate.work()
        if self._estimate.news:
            self.fresh = True
            # The last answer holds for the rest of the contact, even where the fingers no longer answer together.
            last = self.since_s >= self._knowledge.last_s - NEARLY_S
            if (self.alone or last) and (evidence := self.evidence()) is not None:
                posterior = self._knowledge.posterior.judge([evidence])
                self.answer = self.with_exponential(self._conclusion.step(posterior, self.since_s))
        self._update_due(self._estimate)

    def _update_due(self, estimate: TouchEstimate) -> None:
        self.waited_s = estimate.waited_s
        if self.since_s >= self._knowledge.table.lasts_s and self.waited_s < 0.0:
            self._end()

    def _end(self) -> None:
        """Take no more readings of this touch."""
        self._running = False
        self.waited_s = NOTHING_DUE

    def _fault(self, t_s: float, dt_s: float, sensor_c: float) -> ThermalReason:
        """Return the fault of a reading; NONE without one."""
        if not 0.0 <= dt_s <= GAP_S:
            return ThermalReason.READINGS_MISSING
        if not np.isfinite(sensor_c):
            return ThermalReason.NOT_A_NUMBER
        if sensor_c != self._before_c:
            self._before_c, self._changed_s = sensor_c, t_s
        elif t_s - self._changed_s > FLAT_S:
            return ThermalReason.READING_STUCK
        return ThermalReason.NONE

    def stop(self, reason: ThermalReason) -> None:
        """End the touch; a decided answer is kept, any other becomes `unidentifiable`."""
        if not self._running:
            return
        self._end()
        if reason in SENSOR_FAULTS:
            self._estimate = None
        self.answer = replace(self.answer, reason=self.answer.reason or reason)
        if self.answer.status is ThermalStatus.DECIDING:
            # A part of a touch says little about the object's temperature.
            self.answer = replace(
                self.answer,
                status=ThermalStatus.UNIDENTIFIABLE,
                object_c=None,
                object_c_sd=None,
                effusivity=None,
                effusivity_ln_sd=None,
                constants=NOT_RENDERED,
            )

    def again(self, found: ThermalResult) -> None:
        """Touch a spot that the last touch has warmed; its answer holds, because nothing new can be identified."""
        self.release()
        self.warmed, self.since_s = True, 0.0
        holds = found.status in ANSWERED
        self.answer = (
            replace(found, reason=ThermalReason.TOUCHED_BEFORE)
            if holds
            else ThermalResult(ThermalStatus.UNIDENTIFIABLE, reason=ThermalReason.STILL_WARM)
        )

    def release(self) -> None:
        """Forget the touch, because the finger is free."""
        self._end()
        self._estimate = None
        self.answer = NO_CONTACT

    def with_exponential(self, answer: ThermalResult) -> ThermalResult:
        """Return an answer with the result of the paper's method for this finger's readings."""
        if self.since_s >= self._fitted_s + FIT_EVERY_S - HALF_READING_S:
            self._fitted_s, self._fit = self.since_s, self._exponential.fit()
        fit = self._fit
        return replace(
            answer,
            rate_per_s=None if fit is None else fit.rate_per_s,
            exponential_object_c=None if fit is None else fit.object_c,
            exponential_material=self._likeliest_rate(fit),
        )

    def _likeliest_rate(self, fit: ExponentialFit | None) -> str | None:
        """Return the material whose calibrated rate, with its scatter, explains the fit best: the paper's method."""
        if fit is None:
            return None
        k = max(int(np.searchsorted(self._times_s, self.since_s + HALF_READING_S)) - 1, 0)
        sd = self._ln_rate_sds[:, k]
        misfit = 0.5 * ((self._ln_rates[:, k] - np.log(fit.rate_per_s)) / sd) ** 2 + np.log(sd)
        return self._names[int(np.argmin(misfit))]
