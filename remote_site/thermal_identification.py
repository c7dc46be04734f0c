"""Thermal identification of one touch: material and object temperature, improving with time.

Two methods run on the same readings: the paper's (Eq. 7-11: rate of the exponential response, likeliest
calibrated rate) and the calibrated response (`material_evidence`), which alone decides the status.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from common.messages import ThermalStatus
from remote_site.exploration import CONTACT_OFF_N
from remote_site.exponential_response import ExponentialFit
from remote_site.material_evidence import Evidence, Judgement, MaterialEvidence
from remote_site.material_table import MaterialTable
from remote_site.thermal_response import HALF_SAMPLE_S, ThermalResponse

SURE = 0.95
"""Posterior from which a material is named, held over two judgements."""
EARLIEST_S = 1.0
"""Nothing is named, or given up, before this, s after contact."""
LATEST_S = 7.0
"""From here an undecided touch is ambiguous, s."""
LEAST_RATE_SD = 0.02
"""Scatter of ln(rate) between touches of one material, at least."""
KEEP = 0.80
"""A named material stays named down to this posterior."""
LOST_S = 0.05
"""Force has to be away for this long before a contact counts as lost, s."""
NO_DIFFERENCE = "no temperature difference"
CONTACT_LOST = "contact lost"


@dataclass(frozen=True, slots=True)
class ThermalAnswer:
    """What is known about a touch at one time.

    Attributes:
        status: see `ThermalStatus`.
        material: name, set where the status is `identified`.
        best: likeliest calibrated material; None before any contact.
        probability: its probability, 0..1.
        candidates: smallest set of materials that holds 95 % of the probability, likeliest first.
        object_c: object temperature, C; None where nothing is known.
        object_c_sd: its standard deviation, K.
        rate_per_s: rate 1/tau of Eq. 11, 1/s.
        exponential_object_c: Eq. 11's steady-state temperature, C.
        exponential_material: material whose calibrated rate explains it best: the paper's method.
        reason: why a touch is unidentifiable, or why the answer is older than the touch.
    """

    status: ThermalStatus
    material: str | None = None
    best: str | None = None
    probability: float = 0.0
    candidates: dict[str, float] = field(default_factory=dict)
    object_c: float | None = None
    object_c_sd: float | None = None
    rate_per_s: float | None = None
    exponential_object_c: float | None = None
    exponential_material: str | None = None
    reason: str | None = None


NO_CONTACT = ThermalAnswer(ThermalStatus.NO_CONTACT)


class ThermalIdentification:
    """Identification of one finger, one touch after another.

    Attributes:
        answer: what is known now.
        evidence: likelihoods behind it, for a joint judgement; None before the first.
    """

    def __init__(self, table: MaterialTable, evidence: MaterialEvidence | None = None) -> None:
        """Judge against `table`; fingers may share one `MaterialEvidence` made of it."""
        self._table = table
        self._judge = evidence or MaterialEvidence(table)
        self._names = table.names()
        self._ln_rates = np.array([entry.ln_rate for entry in table.materials])
        self._ln_rate_sds = np.maximum([entry.ln_rate_sd for entry in table.materials], LEAST_RATE_SD)
        self.answer = NO_CONTACT
        self.evidence: Evidence | None = None
        self._running = False

    def start(self, t_s: float, sensor_c: float, ambient_c: float | None) -> None:
        """Begin a touch.

        Args:
            t_s: time of contact, s.
            sensor_c: plate at contact, C (best: mean of the last readings before it).
            ambient_c: ambient temperature, C; None where unknown: the calibration's stands in.
        """
        even = 1.0 / len(self._names)
        self._contact_s = t_s
        self._start_c = sensor_c
        self._ambient_c = self._table.ambient_c if ambient_c is None else ambient_c
        self._response = ThermalResponse(t_s, sensor_c, self._table.times_s)
        self._held: tuple[ThermalStatus, str | None] = (ThermalStatus.DECIDING, None)
        self._light_since_s: float | None = None
        self.evidence = None
        self._running = True
        self.answer = ThermalAnswer(
            ThermalStatus.DECIDING,
            best=self._names[0],
            probability=even,
            candidates=dict.fromkeys(self._names, even),
        )

    def step(self, t_s: float, sensor_c: float, force_n: float) -> ThermalAnswer:
        """Take one reading during a touch and return what is known.

        Args:
            t_s: time, s.
            sensor_c: plate, C.
            force_n: contact force, N; below the contact threshold the touch ends.
        """
        if not self._running:
            return self.answer
        if not force_n >= CONTACT_OFF_N:
            if self._light_since_s is None:
                self._light_since_s = t_s
            if t_s - self._light_since_s >= LOST_S:
                self.stop(CONTACT_LOST)
            return self.answer
        self._light_since_s = None
        try:
            completed = self._response.step(t_s, sensor_c)
        except ValueError as error:
            self.stop(f"sensor fault: {error}")
            return self.answer
        if completed:
            drops_k = np.array(self._response.drops_k)
            self.evidence = self._judge.weigh(drops_k, self._start_c, self._ambient_c)
            self._conclude(t_s - self._contact_s, self._judge.judge([self.evidence]))
            self._running = not self._response.complete
        return self.answer

    def stop(self, reason: str) -> None:
        """End the touch; an answer that was reached is kept, otherwise it becomes `unidentifiable`."""
        if not self._running:
            return
        self._running = False
        decided = self.answer.status is not ThermalStatus.DECIDING
        status = self.answer.status if decided else ThermalStatus.UNIDENTIFIABLE
        self.answer = replace(self.answer, status=status, reason=self.answer.reason or reason)
        if not decided:  # half a course says nothing about the object's temperature
            self.answer = replace(self.answer, object_c=None, object_c_sd=None)

    def release(self) -> None:
        """Forget the touch: the finger is free."""
        self._running = False
        self.evidence = None
        self.answer = NO_CONTACT

    def _conclude(self, since_s: float, judgement: Judgement) -> None:
        """Turn a judgement into the answer: a conclusion has to be reached twice, a name sticks."""
        fit = self._response.fit()
        seen = conclude(self._names, judgement, since_s)
        again = self._held == (seen.status, seen.best)
        self._held = (seen.status, seen.best)
        undecided = seen.status in (ThermalStatus.DECIDING, ThermalStatus.AMBIGUOUS)
        if undecided and seen.best == self.answer.material and seen.probability >= KEEP:
            seen = replace(seen, status=ThermalStatus.IDENTIFIED, material=seen.best)
        elif not (undecided or again or seen.material == self.answer.material is not None):
            late = since_s >= LATEST_S - HALF_SAMPLE_S
            waiting = ThermalStatus.AMBIGUOUS if late else ThermalStatus.DECIDING
            seen = replace(seen, status=waiting, material=None, reason=None)
        self.answer = replace(
            seen,
            rate_per_s=None if fit is None else fit.rate_per_s,
            exponential_object_c=None if fit is None else fit.object_c,
            exponential_material=self._likeliest_rate(fit),
        )

    def _likeliest_rate(self, fit: ExponentialFit | None) -> str | None:
        """The paper's classification by rate alone: which calibrated rate, with its scatter, explains it best."""
        if fit is None:
            return None
        k = len(self._response.drops_k) - 1
        sd = self._ln_rate_sds[:, k]
        misfit = 0.5 * ((self._ln_rates[:, k] - np.log(fit.rate_per_s)) / sd) ** 2 + np.log(sd)
        return self._names[int(np.argmin(misfit))]


def conclude(names: list[str], judgement: Judgement, since_s: float) -> ThermalAnswer:
    """What one judgement, `since_s` seconds after contact, says by itself."""
    order = np.argsort(-judgement.probability)
    candidates: dict[str, float] = {}
    for k in order:
        candidates[names[k]] = float(judgement.probability[k])
        if sum(candidates.values()) >= SURE:
            break
    best = names[order[0]]
    probability = float(judgement.probability[order[0]])
    # at a temperature that calibration never met, the shape of the response has to decide by itself
    sure = probability if judgement.usual_temperature else min(probability, float(judgement.by_shape[order[0]]))
    status, reason = ThermalStatus.DECIDING, None
    if since_s >= EARLIEST_S - HALF_SAMPLE_S:
        if judgement.no_difference > 0.5:
            status, reason = ThermalStatus.UNIDENTIFIABLE, NO_DIFFERENCE
        elif judgement.foreign:
            status = ThermalStatus.UNKNOWN
        elif sure >= SURE:
            status = ThermalStatus.IDENTIFIED
        elif since_s >= LATEST_S - HALF_SAMPLE_S:
            status = ThermalStatus.AMBIGUOUS
    return ThermalAnswer(
        status,
        material=best if status is ThermalStatus.IDENTIFIED else None,
        best=best,
        probability=probability,
        candidates=candidates,
        object_c=judgement.object_c,
        object_c_sd=judgement.object_c_sd,
        reason=reason,
    )
