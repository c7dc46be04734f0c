"""What is said about a touch's material, posterior after posterior: statuses with a meaning, names that stick."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from common.wire.messages import ThermalReason, ThermalStatus
from remote_site.thermal.material_posterior import Posterior

CAUTION = 25.0
"""To name a stranger does so many times the harm of leaving a material unnamed. What is stated stays the posterior;
what is named, and kept, follows from a posterior in which strangers weigh so much more."""
SURE = 0.98
"""Cautious posterior from which a material is named, held for HELD_S."""
KEEP = 0.50
"""A named material stays named down to this cautious posterior."""
FOREIGN = 0.50
"""Posterior from which an object is of no calibrated material."""
HELD_S = 0.20
"""A conclusion has to stand for so long, s: one that is reached while the contact still settles passes."""
EARLIEST_S = 0.20
"""Nothing is named before this, s after contact."""
LATEST_S = 7.0
"""From here an undecided touch is ambiguous, s."""
GIVEN_UP_S = 1.0
"""That there is no difference, or that nothing fits, is not said before this, s."""
MISFIT = 2.0
"""Mean square of the prediction errors over their variance beyond which not even the best guess fits."""
SET = 0.95
"""Candidates are the smallest set of materials that holds this much of the probability."""


@dataclass(frozen=True, slots=True)
class ThermalResult:
    """What is known about a touch at one time.

    Attributes:
        status: see `ThermalStatus`.
        material: name, set where the status is `identified`.
        best: likeliest calibrated material; None before any contact.
        probability: its probability, 0..1.
        candidates: smallest set of materials that holds 95 % of the calibrated ones' probability, likeliest first.
        object_c: object temperature, C; None where nothing is known.
        object_c_sd: its standard deviation, K.
        effusivity: of the object, J/(m2 K s^0.5); None where nothing is known.
        effusivity_ln_sd: standard deviation of its logarithm.
        rate_per_s: rate 1/tau of Eq. 11, 1/s.
        exponential_object_c: Eq. 11's steady-state temperature, C.
        exponential_material: material whose calibrated rate explains it best: the paper's method.
        reason: why a touch is unidentifiable, unknown or ambiguous with one candidate, how it ended, or that
            the answer is older than the touch.
    """

    status: ThermalStatus
    material: str | None = None
    best: str | None = None
    probability: float = 0.0
    candidates: dict[str, float] = field(default_factory=dict)
    object_c: float | None = None
    object_c_sd: float | None = None
    effusivity: float | None = None
    effusivity_ln_sd: float | None = None
    rate_per_s: float | None = None
    exponential_object_c: float | None = None
    exponential_material: str | None = None
    reason: ThermalReason = ThermalReason.NONE


NO_CONTACT = ThermalResult(ThermalStatus.NO_CONTACT)


def undecided(prior: Mapping[str, float]) -> ThermalResult:
    """The answer before the first reading, from each material's prior probability."""
    best = max(prior, key=prior.__getitem__)
    return ThermalResult(ThermalStatus.DECIDING, best=best, probability=prior[best], candidates=dict(prior))


class ThermalConclusion:
    """Turns posteriors of one touch, or of all fingers on one object, into answers."""

    __slots__ = ("_held_since_s", "_named", "_names", "_plate_j_m2k", "_seen")

    def __init__(self, names: Sequence[str], plate_j_m2k: float) -> None:
        """Begin a touch; `names` are the calibrated materials, `plate_j_m2k` the table's heat capacity of the plate."""
        self._names = names
        self._plate_j_m2k = plate_j_m2k
        self._named: str | None = None
        self._seen: tuple[ThermalStatus, str | None] = (ThermalStatus.DECIDING, None)
        self._held_since_s = 0.0

    def step(self, posterior: Posterior, since_s: float) -> ThermalResult:
        """The answer `since_s` seconds after contact."""
        seen = self._conclude(posterior, since_s)
        if (seen.status, seen.best) != self._seen:
            self._seen, self._held_since_s = (seen.status, seen.best), since_s
        held = since_s - self._held_since_s >= HELD_S - 1e-9
        undecided_now = seen.status in (ThermalStatus.DECIDING, ThermalStatus.AMBIGUOUS)
        kept = self._named is not None and seen.best == self._named and seen.probability >= KEEP * _doubt(posterior)
        if undecided_now and kept:
            return replace(seen, status=ThermalStatus.IDENTIFIED, material=self._named, reason=ThermalReason.NONE)
        if not held and not undecided_now and seen.material != self._named:
            return replace(seen, status=_waiting(since_s), material=None, reason=ThermalReason.NONE)
        self._named = seen.material
        return seen

    def _conclude(self, posterior: Posterior, since_s: float) -> ThermalResult:
        """What one posterior says by itself."""
        calibrated = max(1.0 - posterior.foreign, 1e-12)
        order = np.argsort(-posterior.probability)
        candidates: dict[str, float] = {}
        for k in order:
            candidates[self._names[k]] = float(posterior.probability[k])
            if sum(candidates.values()) >= SET * calibrated:
                break
        best, probability = self._names[order[0]], float(posterior.probability[order[0]])
        status, reason = _waiting(since_s), ThermalReason.NONE
        if since_s >= GIVEN_UP_S - 1e-9 and posterior.no_difference > 0.5:
            status, reason = ThermalStatus.UNIDENTIFIABLE, ThermalReason.NO_DIFFERENCE
        elif since_s >= GIVEN_UP_S - 1e-9 and posterior.misfit > MISFIT:
            status, reason = ThermalStatus.UNKNOWN, ThermalReason.NO_FIT
        elif since_s >= EARLIEST_S - 1e-9:
            if posterior.foreign > FOREIGN:
                status, reason = ThermalStatus.UNKNOWN, ThermalReason.NOT_CALIBRATED
            elif probability >= SURE * _doubt(posterior) and posterior.misfit <= MISFIT:
                status = ThermalStatus.IDENTIFIED
        if status is ThermalStatus.AMBIGUOUS and len(candidates) == 1:
            reason = ThermalReason.NOT_RULED_OUT
        return ThermalResult(
            status,
            material=best if status is ThermalStatus.IDENTIFIED else None,
            best=best,
            probability=probability,
            candidates=candidates,
            object_c=posterior.object_c,
            object_c_sd=posterior.object_c_sd,
            effusivity=float(np.exp(posterior.ln_effusivity)) * self._plate_j_m2k,
            effusivity_ln_sd=posterior.ln_effusivity_sd,
            reason=reason,
        )


def _doubt(posterior: Posterior) -> float:
    """What probabilities have to be divided by where strangers weigh CAUTION times as much."""
    return 1.0 + (CAUTION - 1.0) * posterior.foreign


def _waiting(since_s: float) -> ThermalStatus:
    return ThermalStatus.AMBIGUOUS if since_s >= LATEST_S - 1e-9 else ThermalStatus.DECIDING
