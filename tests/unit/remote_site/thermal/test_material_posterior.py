"""Joint judgement of several fingers against numerical integration, and its benefit."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from remote_site.thermal.conduction import Array
from remote_site.thermal.material_posterior import (
    ANYWHERE,
    OWN_EFFUSIVITY,
    SAME_OBJECT,
    SHARED_ERROR,
    SMALLEST_DIFFERENCE_K,
    STEP_SD,
    STEPS,
    MaterialPosterior,
    Posterior,
)
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.touch_estimate import ANYWHERE_K, TouchEvidence
from remote_site.thermal.touch_hypotheses import Substances
from tests.unit.remote_site.made_touches import AMBIENT_C, MATERIALS, MadeTouch, made_touches, true_table
from tests.unit.remote_site.played_touches import estimated

TABLE = true_table({name: MATERIALS[name] for name in ("stone", "plastic")})
SMALL = Substances(np.array([-0.1, -1.4, -0.8]), np.array([0.05, 0.08, 0.04]), np.array([0.5, 0.3, 0.2]), 2)
"""Two calibrated materials and one foreign substance."""
OWN = OWN_EFFUSIVITY * np.array([0.05, 0.08, 0.065])
"""Variance of each finger's own error of ln effusivity; the foreign substance has the calibrated ones' median."""
OF_PIECE = np.array([0.05, 0.08, 0.04]) - OWN * [1.0, 1.0, 0.0]
OFFSET_K, OFFSET_SD_K = 0.0, 1.75
GRID_K, GRID_LN = np.linspace(-45.0, 45.0, 1501), np.linspace(-3.5, 2.0, 551)


def cell() -> float:
    return float((GRID_K[1] - GRID_K[0]) * (GRID_LN[1] - GRID_LN[0]))


class Finger:
    """A finger whose readings give a normal likelihood in temperature and ln effusivity, another for each substance."""

    def __init__(self, seed: int, start_c: float, warm_k: float = 0.0) -> None:
        rng = np.random.default_rng(seed)
        self.start_c = start_c
        self.middle = np.column_stack((warm_k + rng.normal(0.0, 1.5, 3), rng.normal(-0.7, 0.4, 3)))
        root = rng.normal(size=(3, 2, 2)) * [1.0, 0.25]
        self.information = np.linalg.inv(np.einsum("mki,mkj->mij", root, root) + np.diag([0.3, 0.02]))
        self.height = rng.normal(0.0, 1.0, 3)

    def blurred(self, substance: int) -> Array:
        """Information (2, 2) about the piece, from which the finger's effusivity differs by an error of its own."""
        return np.asarray(np.linalg.inv(np.linalg.inv(self.information[substance]) + np.diag([0.0, OWN[substance]])))

    def likelihood(self, substance: int) -> Array:
        """Likelihood of the piece on the grid."""
        information = self.blurred(substance)
        away = np.stack(np.meshgrid(GRID_K, GRID_LN, indexing="ij"), axis=-1) - self.middle[substance]
        square = np.einsum("...i,ij,...j->...", away, information, away)
        lower = np.linalg.det(information) / np.linalg.det(self.information[substance])
        return np.asarray(np.sqrt(lower) * np.exp(self.height[substance] - 0.5 * square))

    def evidence(self) -> TouchEvidence:
        """As the filters hand it over: after a prior of any temperature, N(0, ANYWHERE_K), and the substance's own."""
        ln, means, covariances = [], [], []
        for m in range(3):
            prior = np.diag([ANYWHERE_K**2, SMALL.effusivity_variance[m]])
            at = np.array([0.0, SMALL.ln_effusivity[m]])
            own = np.linalg.inv(self.information[m])
            ln.append(
                self.height[m]
                + multivariate_normal(at, prior + own).logpdf(self.middle[m])
                + 0.5 * np.linalg.slogdet(2.0 * np.pi * own)[1]
            )
            covariance = np.linalg.inv(self.information[m] + np.linalg.inv(prior))
            covariances.append(covariance)
            means.append(covariance @ (self.information[m] @ self.middle[m] + np.linalg.solve(prior, at)))
        return TouchEvidence(np.array(ln), np.array(means), np.array(covariances), AMBIENT_C, self.start_c, 1.0)


def usual() -> Array:
    """Density of the temperatures that the calibration's objects had, on the grid: even, with soft ends."""
    step_k = OFFSET_SD_K / np.sqrt(np.var(STEPS) + STEP_SD**2)
    rows = [norm(OFFSET_K + step * step_k, STEP_SD * step_k).pdf(GRID_K) for step in STEPS]
    return np.asarray(np.mean(rows, axis=0))


def test_temperatures_like_those_of_the_calibration_are_even_and_scatter_as_they_did() -> None:
    density = usual()
    width_k = np.sqrt(3.0) * OFFSET_SD_K
    within = density[np.abs(GRID_K - OFFSET_K) < 0.5 * width_k]
    assert within.max() / within.min() < 1.1
    assert np.sqrt(density @ GRID_K**2 / density.sum()) == pytest.approx(OFFSET_SD_K, rel=0.01)


def independent_share(fingers: list[Finger]) -> float:
    """Share of the information that counts: 1 over the variance of a mean whose terms have SHARED_ERROR in common."""
    weight = np.array([max(finger.blurred(m)[0, 0] for m in range(3)) for finger in fingers])
    correlation = np.full((len(fingers), len(fingers)), SHARED_ERROR) + (1.0 - SHARED_ERROR) * np.eye(len(fingers))
    error = correlation / np.sqrt(np.outer(weight, weight))
    return float(weight.sum() / (weight @ error @ weight))


def densities(fingers: list[Finger], share: float) -> list[Array]:
    """Prior times likelihoods of each substance on the grid, with a share of each finger's information."""
    found = []
    for m in range(3):
        at_k = (1.0 - ANYWHERE) * usual() + ANYWHERE * norm(0.0, ANYWHERE_K).pdf(GRID_K)
        at_ln = norm(SMALL.ln_effusivity[m], np.sqrt(OF_PIECE[m])).pdf(GRID_LN)
        density = SMALL.probability[m] * at_k[:, None] * at_ln
        for finger in fingers:
            density = density * finger.likelihood(m) ** share
        found.append(density * cell())
    return found


@pytest.mark.long
@pytest.mark.parametrize(("count", "seed"), [(1, 0), (2, 1), (5, 0)])
def test_the_posterior_is_the_integral(count: int, seed: int) -> None:
    fingers = [Finger(10 * seed + k, AMBIENT_C + 10.0 + k) for k in range(count)]
    share = independent_share(fingers)
    found = densities(fingers, share)
    each = np.array([density.sum() for density in found])
    total = sum(found) / each.sum()
    mean_k = float((total.sum(axis=1) * GRID_K).sum())
    mean_ln = float((total.sum(axis=0) * GRID_LN).sum())
    said = MaterialPosterior(TABLE, SMALL).judge([finger.evidence() for finger in fingers])
    assert [*said.probability, said.foreign] == pytest.approx(each / each.sum(), abs=1e-3)
    assert said.object_c == pytest.approx(AMBIENT_C + mean_k, abs=0.01)
    assert said.object_c_sd == pytest.approx(np.sqrt(total.sum(axis=1) @ (GRID_K - mean_k) ** 2), rel=0.01)
    assert said.ln_effusivity == pytest.approx(mean_ln, abs=0.002)
    assert said.ln_effusivity_sd == pytest.approx(np.sqrt(total.sum(axis=0) @ (GRID_LN - mean_ln) ** 2), rel=0.01)
    apart = np.prod([sum(density.sum() for density in densities([finger], share)) for finger in fingers])
    odds = SAME_OBJECT / (1.0 - SAME_OBJECT) * each.sum() / apart
    assert said.same_object == (1.0 if count == 1 else pytest.approx(odds / (1.0 + odds), abs=1e-3))


@pytest.mark.parametrize("start_k", [0.5, 3.0, 10.0])
def test_the_chance_of_no_difference_is_the_integral_too(start_k: float) -> None:
    finger = Finger(3, AMBIENT_C + start_k)
    below = np.cumsum(sum(densities([finger], 1.0)).sum(axis=1))
    below /= below[-1]
    near = np.interp(start_k + SMALLEST_DIFFERENCE_K, GRID_K, below)
    near -= np.interp(start_k - SMALLEST_DIFFERENCE_K, GRID_K, below)
    said = MaterialPosterior(TABLE, SMALL).judge([finger.evidence()])
    assert said.no_difference == pytest.approx(near, abs=0.02)


def test_one_finger_with_a_difference_is_enough() -> None:
    warm, cold = Finger(4, AMBIENT_C), Finger(4, AMBIENT_C + 15.0)
    warm.middle[:, 0] = cold.middle[:, 0] = 0.2
    judge = MaterialPosterior(TABLE, SMALL)
    assert judge.judge([warm.evidence()]).no_difference > 0.5
    assert judge.judge([warm.evidence(), cold.evidence()]).no_difference < 1e-6


def test_the_order_of_fingers_does_not_matter_and_one_that_knows_nothing_changes_nothing() -> None:
    fingers = [Finger(seed, AMBIENT_C + 10.0) for seed in range(3)]
    blind = Finger(9, AMBIENT_C + 10.0)
    blind.information = blind.information * 1e-9
    blind.height[:] = 0.0
    judge = MaterialPosterior(TABLE, SMALL)
    once = judge.judge([finger.evidence() for finger in fingers])
    for more in ([*reversed(fingers)], [*fingers, blind]):
        again = judge.judge([finger.evidence() for finger in more])
        assert again.probability == pytest.approx(once.probability, abs=1e-6)
        assert again.object_c == pytest.approx(once.object_c, abs=1e-5)
        assert again.object_c_sd == pytest.approx(once.object_c_sd, rel=1e-5)


@pytest.mark.parametrize("apart_k", [-2.0, 2.0])
def test_fingers_whose_ambient_thermometers_differ_agree_on_one_object(apart_k: float) -> None:
    judge = MaterialPosterior(TABLE, SMALL)
    object_k = 4.0
    fingers = [Finger(seed, AMBIENT_C + 12.0) for seed in (1, 2)]
    for finger, factor in zip(fingers, (100.0, 1.0), strict=True):  # one knows more than the other
        finger.information = finger.information * factor
        finger.middle[:, 0] = object_k
    alike = judge.judge([finger.evidence() for finger in fingers])
    # the object and the plate are as warm as before, but 2 K further from what the second finger calls ambient
    fingers[1].middle[:, 0] -= apart_k
    other = replace(fingers[1].evidence(), ambient_c=AMBIENT_C + apart_k)
    found = judge.judge([fingers[0].evidence(), other])
    assert found.object_c == pytest.approx(alike.object_c, abs=0.1)
    assert found.same_object == pytest.approx(alike.same_object, abs=0.02)
    assert found.probability == pytest.approx(alike.probability, abs=0.1)


def test_an_error_that_all_fingers_share_stays_with_any_number_of_them() -> None:
    alike = replace(Finger(1, AMBIENT_C + 10.0).evidence(), common_k2=np.full(3, 0.25))
    judge = MaterialPosterior(TABLE, SMALL)
    for count in (1, 2, 5):
        shared = judge.judge([alike] * count)
        plain = judge.judge([replace(alike, common_k2=0.0)] * count)
        assert shared.object_c_sd**2 == pytest.approx(plain.object_c_sd**2 + 0.25)
        assert shared.probability == pytest.approx(plain.probability)


def pair(
    knowledge: ThermalKnowledge, name: str, seed: int, starts_k: tuple[float, float], seconds: float
) -> tuple[Posterior, MadeTouch]:
    starts_c = AMBIENT_C + np.array(starts_k)
    touches = made_touches(name, 2, seed, seconds, start_c=starts_c, same_piece=True)
    return knowledge.posterior.judge([estimated(knowledge, touch) for touch in touches]), touches[0]


@pytest.mark.long
def test_two_staggered_fingers_beat_two_equal_ones(knowledge: ThermalKnowledge) -> None:
    """On the same pieces after 0.5 s: the temperature is known better, and the truth is likelier."""
    sds, ln_true, errors = {}, {}, {}
    for starts_k in ((10.0, 10.0), (6.0, 14.0)):
        found = [(name, *pair(knowledge, name, seed, starts_k, 0.5)) for name in MATERIALS for seed in range(3)]
        sds[starts_k] = [said.object_c_sd for _, said, _ in found]
        ln_true[starts_k] = [np.log(said.probability[list(MATERIALS).index(name)]) for name, said, _ in found]
        errors[starts_k] = [said.object_c - touch.object_c for _, said, touch in found]
    equal, staggered = sds
    assert np.mean(sds[staggered]) < 0.7 * np.mean(sds[equal])
    assert np.mean(ln_true[staggered]) > np.mean(ln_true[equal])
    assert np.std(errors[staggered]) < np.std(errors[equal])
    assert max(abs(error) / sd for error, sd in zip(errors[staggered], sds[staggered], strict=True)) < 3.5


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (("metal", None), ("plastic", None)),
        (("stone", None), ("plastic", None)),
        (("metal", None), ("stone", None)),
        (("metal", 20.0), ("metal", 26.0)),
    ],
)
def test_fingers_on_different_objects_are_recognised(
    knowledge: ThermalKnowledge, first: tuple[str, float | None], second: tuple[str, float | None]
) -> None:
    """Be they of one material at different temperatures."""
    found = [
        estimated(knowledge, made_touches(name, 1, seed=5, seconds=1.5, object_c=object_c)[0])
        for name, object_c in (first, second)
    ]
    assert knowledge.posterior.judge(found).same_object < 0.1


@pytest.mark.long
def test_fingers_on_one_object_are_not_torn_apart(knowledge: ThermalKnowledge) -> None:
    for name in MATERIALS:
        for seed in range(3):
            assert pair(knowledge, name, seed, (6.0, 14.0), 1.5)[0].same_object > 0.5, (name, seed)


@pytest.mark.long
def test_fingers_that_gave_up_each_others_material_are_still_judged(knowledge: ThermalKnowledge) -> None:
    """Nothing is left that explains both: they touch two objects, and every number stays one."""
    metal, plastic = (
        estimated(knowledge, made_touches(name, 1, seed=7, seconds=4.0, object_c=object_c)[0])
        for name, object_c in (("metal", 21.0), ("plastic", 25.0))
    )
    said = knowledge.posterior.judge([metal, plastic])
    assert said.same_object < 0.01
    assert said.probability.sum() + said.foreign == pytest.approx(1.0)
    assert np.isfinite([said.object_c, said.object_c_sd, said.ln_effusivity, said.ln_effusivity_sd]).all()
