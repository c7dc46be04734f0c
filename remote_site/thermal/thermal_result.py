"""Concludes from posteriors the status of a touch, its named material, and the constants to render."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from common.scenes.materials import ALIASES, materials
from common.wire.messages import OBJECT_UNKNOWN_SD_K, ThermalReason, ThermalStatus
from remote_site.thermal.contact_change import NEARLY_S
from remote_site.thermal.estimate_drift import EstimateDrift
from remote_site.thermal.material_posterior import Posterior

CAUTION = 5.0
"""Harm of naming a foreign material, relative to that of leaving a material unnamed.

The reported probabilities are those of the posterior. The named material follows from a cautious posterior, in which
foreign materials weigh CAUTION times as much.
"""
SURE = 0.995
"""Minimum cautious posterior of a material to be named, during HELD_S."""
KEEP = 0.50
"""Minimum cautious posterior of a named material to stay named."""
FOREIGN = 0.50
"""Posterior of foreign materials above which the object is of no calibrated material."""
HELD_S = 0.20
"""Minimum duration of a conclusion before it is reported, s; a settling contact causes shorter ones."""
EARLIEST_S = 0.20
"""Earliest time after contact at which a material is named, s."""
LATEST_S = 6.0
"""Time after contact from which an undecided touch is ambiguous, s."""
GIVEN_UP_S = 1.0
"""Earliest time after contact at which a missing difference or a misfit is reported, s."""
MISFIT = 2.0
"""Mean square of the prediction errors over their variance above which not even the best hypothesis fits."""
SET = 0.95
"""Probability of the smallest set of materials that is reported as candidates."""
VAGUE_LN_SD = 0.7
"""Largest standard deviation of ln effusivity that is rendered (a factor of two)."""
Constants = tuple[float, float, float]
"""Conductivity, W/mK, density, kg/m3, and specific heat, J/kgK."""
NOT_RENDERED: Constants = (0.0, 0.0, 0.0)
"""Constants of an object that is not rendered."""
_RENDERED = (ThermalStatus.DECIDING, ThermalStatus.IDENTIFIED, ThermalStatus.AMBIGUOUS, ThermalStatus.UNKNOWN)


@dataclass(frozen=True, slots=True)
class ThermalResult:
    """Estimates of a touch at one time.

    Attributes:
        status: see `ThermalStatus`.
        material: name of the material; None unless the status is `identified`.
        best: likeliest calibrated material; None before any contact.
        probability: probability of `best`, 0..1.
        candidates: smallest set of materials with 95 % of the calibrated materials' probability, likeliest first.
        object_c: temperature of the object, C; None if unknown.
        object_c_sd: standard deviation of the temperature, K; OBJECT_UNKNOWN_SD_K where no hypothesis fits.
        effusivity: effusivity of the object, J/(m2 K s^0.5); None if unknown.
        effusivity_ln_sd: standard deviation of ln effusivity.
        constants: constants to render.
        rate_per_s: rate 1/tau of Eq. 11, 1/s.
        exponential_object_c: steady-state temperature of Eq. 11, C.
        exponential_material: material whose calibrated rate explains `rate_per_s` best, the paper's method.
        reason: reason of an unidentifiable or unknown touch, or of an ambiguous one with one candidate; or how the
            touch ended, or that the answer is older than the touch.
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
    constants: Constants = NOT_RENDERED
    rate_per_s: float | None = None
    exponential_object_c: float | None = None
    exponential_material: str | None = None
    reason: ThermalReason = ThermalReason.NONE


@dataclass(frozen=True, slots=True)
class NamingRule:
    """Rule by which a material is named; the study `second-world` shows what others would do.

    Attributes:
        sure: minimum cautious posterior of a material to be named, during `held_s`.
        caution: harm of naming a foreign material, relative to that of leaving a material unnamed.
        held_s: minimum duration of a conclusion before it is reported, s.
    """

    sure: float = SURE
    caution: float = CAUTION
    held_s: float = HELD_S

    def doubt(self, posterior: Posterior) -> float:
        """Return the divisor of a cautious posterior, in which foreign materials weigh `caution` times as much."""
        return 1.0 + (self.caution - 1.0) * posterior.foreign


NO_CONTACT = ThermalResult(ThermalStatus.NO_CONTACT)


def undecided(prior: Mapping[str, float]) -> ThermalResult:
    """Return the answer before the first reading, from each material's prior probability."""
    best = max(prior, key=prior.__getitem__)
    return ThermalResult(ThermalStatus.DECIDING, best=best, probability=prior[best], candidates=dict(prior))


class ThermalConclusion:
    """Turns posteriors of one touch, or of all fingers on one object, into answers."""

    def __init__(
        self,
        names: Sequence[str],
        plate_j_m2k: float,
        rule: NamingRule = NamingRule(),
        latest_s: float = LATEST_S,
    ) -> None:
        """Begin a touch.

        Args:
            names: calibrated materials.
            plate_j_m2k: the table's heat capacity of the plate, J/(m2 K).
            rule: when to name a material.
            latest_s: time after contact from which an undecided touch is ambiguous, s.
        """
        self._latest_s = latest_s
        self._names = names
        self._rule = rule
        self._plate_j_m2k = plate_j_m2k
        self._named: str | None = None
        self._seen: tuple[ThermalStatus, str | None] = (ThermalStatus.DECIDING, None)
        self._held_since_s = 0.0
        self._drift, self._drifted = EstimateDrift(), False
        self._sources: Sequence[object] = ()

    def step(self, posterior: Posterior, since_s: float, sources: Sequence[object] = ()) -> ThermalResult:
        """Return the answer.

        Args:
            posterior: posterior of all evidence until now.
            since_s: time after contact, s.
            sources: fingers whose evidence it is. An estimate is compared with earlier ones of the same fingers only.
        """
        if sources != self._sources:
            self._sources = sources
            self._drift, self._drifted = EstimateDrift(), False
        self._drifted = self._drift.step(since_s, posterior.object_c, posterior.object_c_sd) or self._drifted
        answer = self._held(posterior, since_s)
        return replace(answer, constants=rendered_constants(answer))

    def _held(self, posterior: Posterior, since_s: float) -> ThermalResult:
        """Return a conclusion that has lasted long enough; until then, the touch is undecided or keeps its name."""
        seen = self._conclude(posterior, since_s)
        if (seen.status, seen.best) != self._seen:
            self._seen, self._held_since_s = (seen.status, seen.best), since_s
        held = since_s - self._held_since_s >= self._rule.held_s - 1e-9
        undecided_now = seen.status in (ThermalStatus.DECIDING, ThermalStatus.AMBIGUOUS)
        kept = (
            self._named is not None
            and seen.best == self._named
            and seen.probability >= KEEP * self._rule.doubt(posterior)
        )
        if undecided_now and kept:
            return replace(seen, status=ThermalStatus.IDENTIFIED, material=self._named, reason=ThermalReason.NONE)
        if not held and not undecided_now and seen.material != self._named:
            return replace(seen, status=self._waiting(since_s), material=None, reason=ThermalReason.NONE)
        self._named = seen.material
        return seen

    def _conclude(self, posterior: Posterior, since_s: float) -> ThermalResult:
        """Return the conclusion from one posterior alone."""
        calibrated = max(1.0 - posterior.foreign, 1e-12)
        order = np.argsort(-posterior.probability)
        candidates: dict[str, float] = {}
        for k in order:
            candidates[self._names[k]] = float(posterior.probability[k])
            if sum(candidates.values()) >= SET * calibrated:
                break
        best, probability = self._names[order[0]], float(posterior.probability[order[0]])
        status, reason = self._waiting(since_s), ThermalReason.NONE
        if since_s >= GIVEN_UP_S - 1e-9 and posterior.no_difference > 0.5:
            status, reason = ThermalStatus.UNIDENTIFIABLE, ThermalReason.NO_DIFFERENCE
        elif since_s >= GIVEN_UP_S - 1e-9 and (posterior.misfit > MISFIT or self._drifted):
            status, reason = ThermalStatus.UNKNOWN, ThermalReason.NO_FIT
        elif since_s >= EARLIEST_S - 1e-9:
            if posterior.foreign > FOREIGN:
                status, reason = ThermalStatus.UNKNOWN, ThermalReason.NOT_CALIBRATED
            elif probability >= self._rule.sure * self._rule.doubt(posterior) and posterior.misfit <= MISFIT:
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
            object_c_sd=OBJECT_UNKNOWN_SD_K if reason is ThermalReason.NO_FIT else posterior.object_c_sd,
            effusivity=float(np.exp(posterior.ln_effusivity)) * self._plate_j_m2k,
            effusivity_ln_sd=posterior.ln_effusivity_sd,
            reason=reason,
        )

    def _waiting(self, since_s: float) -> ThermalStatus:
        return ThermalStatus.AMBIGUOUS if since_s >= self._latest_s - NEARLY_S else ThermalStatus.DECIDING


def rendered_constants(answer: ThermalResult) -> Constants:
    """Return the constants to render.

    An identified material has its own constants. Before that, the constants are the mean (in logarithms) over the
    likely materials, scaled to the effusivity of the running estimate. The finger therefore feels something from the
    first moment, and no jump when the material is identified.
    """
    if answer.status not in _RENDERED or answer.effusivity is None or answer.effusivity_ln_sd is None:
        return NOT_RENDERED
    if answer.material is not None:
        return _constants_of(answer.material) or NOT_RENDERED
    if answer.effusivity_ln_sd > VAGUE_LN_SD:
        return NOT_RENDERED
    known = {name: found for name in answer.candidates if (found := _constants_of(name)) is not None}
    if not known:
        return NOT_RENDERED
    weights = [max(answer.candidates[name], 1e-6) for name in known]
    conductivity, density, heat = np.exp(np.average(np.log(list(known.values())), axis=0, weights=weights))
    wanted = answer.effusivity / float(np.sqrt(conductivity * density * heat))
    return float(conductivity) * wanted, float(density), float(heat) * wanted


def _constants_of(name: str) -> Constants | None:
    """Return the constants of a calibrated material by its name; None if no scene knows it."""
    entry = materials().get(ALIASES.get(name, name))
    return None if entry is None else (entry.conductivity_w_mk, entry.density_kg_m3, entry.specific_heat_j_kgk)
