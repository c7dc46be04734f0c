"""The filters of one touch against exact inference, and on touches made by another physics."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from remote_site.thermal.conduction import Array
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.touch_estimate import ANYWHERE_K, FORGET, TouchEstimate
from remote_site.thermal.touch_hypotheses import SPACING, Substances, TouchHypotheses
from remote_site.thermal.touch_model import Contacts, SensorConstants, TouchModel
from tests.unit.remote_site.made_touches import (
    AMBIENT_C,
    MATERIALS,
    PLATE_J_M2K,
    MadeMaterial,
    MadeTouch,
    made_touches,
    measured,
    plate_courses,
    pressed,
    true_table,
)
from tests.unit.remote_site.made_touches import SENSOR as MADE_SENSOR
from tests.unit.remote_site.played_touches import estimated

TABLE = true_table()
SENSOR = SensorConstants(TABLE.leak_per_s, TABLE.half_force_n, TABLE.early_s)


def prior_of_temperatures(table: MaterialTable, start_c: float) -> tuple[Array, Array]:
    """Mean and variances of object, plate and back relative to the reading at contact, K."""
    ambient_k = AMBIENT_C - start_c
    mean = np.array([ambient_k, 0.0, (1.0 - table.back_share) * ambient_k])
    return mean, np.array([ANYWHERE_K, table.start_sd_k, table.back_sd_k]) ** 2


def test_the_filter_is_exact_with_only_the_temperatures_unknown() -> None:
    """Then the readings are jointly normal: their probability and the regression on the courses are textbook."""
    touch = made_touches("stone", 1, seed=5, seconds=1.5)[0]
    e, h = (np.array([MATERIALS["stone"].effusivity]), np.array([MATERIALS["stone"].conductance_w_m2k]))
    contacts = Contacts(np.log(e / PLATE_J_M2K), np.log(h / PLATE_J_M2K), np.array([np.inf]))
    ln_lag, first = np.log([MADE_SENSOR.lag_s]), np.zeros(1, dtype=np.intp)
    alone = TouchHypotheses(contacts, first, ln_lag, first, np.zeros(1), 1e-14 * np.eye(3)[None])
    known = Substances(contacts.ln_effusivity, np.array([1e-14]), np.ones(1), 1)
    found = TouchEstimate(TABLE, known, alone, touch.start_c, 0.0, AMBIENT_C)
    model = TouchModel(SENSOR, contacts, first, ln_lag)
    rows = []
    for _, sensor_c, force_n in touch.after():
        found.take(0.01, sensor_c, force_n)
        found.work()
        model.advance((0.01,), np.array([force_n]))
        rows.append(model.courses[0, :3].copy())
    courses = np.array(rows)
    y = np.array([sensor_c for _, sensor_c, _ in touch.after()]) - touch.start_c
    mean, variances = prior_of_temperatures(TABLE, touch.start_c)
    covariance = courses * variances @ courses.T + TABLE.noise_k**2 * np.eye(len(y))
    rest = y - courses @ mean
    ln_likelihood = -0.5 * (np.linalg.slogdet(covariance)[1] + rest @ np.linalg.solve(covariance, rest))
    posterior = np.linalg.inv(np.diag(1.0 / variances) + courses.T @ courses / TABLE.noise_k**2)
    temperatures = mean + posterior @ courses.T @ rest / TABLE.noise_k**2
    found.settle()
    said = found.evidence()
    assert said.ln_likelihood[0] == pytest.approx(ln_likelihood, abs=1e-3)
    assert said.mean[0, 0] == pytest.approx(temperatures[0] + touch.start_c - AMBIENT_C, abs=1e-4)
    assert said.covariance[0, 0, 0] == pytest.approx(posterior[0, 0], rel=1e-4)


def marginal(touch: MadeTouch, draws: Array) -> tuple[Array, Array, Array]:
    """For (n, 3) draws of ln effusivity, ln conductance and ln lag, with the temperatures integrated in closed form.

    Ln probability of the readings, object temperature above ambient, K, and its variance, (n,) each.
    """
    n = len(draws)
    contacts = Contacts(draws[:, 0], draws[:, 1], np.full(n, np.inf))
    model = TouchModel(SENSOR, contacts, np.arange(n), draws[:, 2])
    mean, variances = prior_of_temperatures(TABLE, touch.start_c)
    noise = TABLE.noise_k**2
    normal, right, square = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(n)
    for _, sensor_c, force_n in touch.after():
        model.advance((0.01,), np.array([force_n]))
        row = model.courses[:, :3]
        rest = sensor_c - touch.start_c - row @ mean
        normal += row[:, :, None] * row[:, None, :] / noise
        right += row * rest[:, None] / noise
        square += rest * rest / noise
    information = normal + np.diag(1.0 / variances)
    solved = np.linalg.solve(information, right[..., None])[..., 0]
    ln_det = np.linalg.slogdet(information)[1] + np.log(variances).sum() + len(touch.after()) * np.log(noise)
    ln = -0.5 * (ln_det + square - np.einsum("ni,ni->n", right, solved))
    return ln, mean[0] + solved[:, 0] + touch.start_c - AMBIENT_C, np.linalg.inv(information)[:, 0, 0]


def exact(number: int, touch: MadeTouch) -> tuple[float, float, float]:
    """Ln probability of the readings, object temperature above ambient, K, and its sd, for material `number`.

    By importance sampling from a normal that closes in on the posterior round by round.
    """
    entry, rng = TABLE.materials[number], np.random.default_rng(3)
    prior_mean = np.array([entry.ln_effusivity, entry.ln_conductance, TABLE.ln_lag])
    prior = np.diag([entry.covariance[0][0], entry.covariance[1][1], TABLE.ln_lag_sd**2])
    prior_law = multivariate_normal(prior_mean, prior)
    mean, covariance = prior_mean, prior
    for share in (1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0, 1.0, 1.0):
        proposal = multivariate_normal(mean, covariance)
        draws = proposal.rvs(1200, random_state=rng)
        ln = share * marginal(touch, draws)[0] + prior_law.logpdf(draws) - proposal.logpdf(draws)
        weight = np.exp(ln - logsumexp(ln))
        mean = weight @ draws
        away = draws - mean
        covariance = 1.3 * np.einsum("n,ni,nj->ij", weight, away, away)
    proposal = multivariate_normal(mean, 1.3 * covariance)
    draws = proposal.rvs(4000, random_state=rng)
    ln, object_k, variance = marginal(touch, draws)
    ln = ln + prior_law.logpdf(draws) - proposal.logpdf(draws)
    total = float(logsumexp(ln))
    weight = np.exp(ln - total)
    assert 1.0 / (weight @ weight) > 1000.0, "too few draws count"
    middle = float(weight @ object_k)
    sd = float(np.sqrt(weight @ (variance + (object_k - middle) ** 2)))
    return total - float(np.log(len(draws))), middle, sd


def second_of(name: str, contact_z: float) -> MadeTouch:
    """One second of a touch whose contact is `contact_z` standard deviations better than usual."""
    material = MATERIALS[name]
    better = MadeMaterial(
        material.effusivity,
        material.conductance_w_m2k * float(np.exp(material.contact_sd * contact_z)),
        piece_sd=0.0,
        contact_sd=0.0,
    )
    return made_touches(name, 1, seed=7, seconds=1.0, object_c=22.0, material=better)[0]


@pytest.mark.long
@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("contact_z", [1.5, -2.0])
def test_the_approximation_is_near_brute_force(knowledge: ThermalKnowledge, name: str, contact_z: float) -> None:
    """Half a unit of ln probability moves a posterior of 0.90 to 0.94: more than that would show in the answers."""
    compare_with_brute_force(knowledge, name, contact_z)


@pytest.mark.parametrize("name", MATERIALS)
def test_finer_guesses_come_to_brute_force(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the estimator leaves out is the bend of the courses between guesses, and nothing else."""
    for spacing in SPACING:
        monkeypatch.setitem(SPACING, spacing, 0.05)
    compare_with_brute_force(ThermalKnowledge.of(TABLE), name, -2.0, nearer=0.5)


@cache
def exact_of(name: str, contact_z: float) -> tuple[float, float, float]:
    """`exact` of a second of a touch."""
    return exact(list(MATERIALS).index(name), second_of(name, contact_z))


def compare_with_brute_force(knowledge: ThermalKnowledge, name: str, contact_z: float, nearer: float = 1.0) -> None:
    touch, number = second_of(name, contact_z), list(MATERIALS).index(name)
    ln_likelihood, object_k, object_sd_k = exact_of(name, contact_z)
    said = estimated(knowledge, touch)
    assert said.ln_likelihood[number] == pytest.approx(ln_likelihood, abs=0.5 * nearer)
    assert said.mean[number, 0] == pytest.approx(object_k, abs=0.35 * object_sd_k * nearer)
    assert np.sqrt(said.covariance[number, 0, 0]) == pytest.approx(object_sd_k, rel=0.25 * nearer + 0.05)


@pytest.mark.long
@pytest.mark.parametrize("name", MATERIALS)
def test_the_truth_lies_within_the_stated_uncertainty(knowledge: ThermalKnowledge, name: str) -> None:
    number = list(MATERIALS).index(name)
    zs, misfits = [], []
    for touch in made_touches(name, 8, seed=11, seconds=3.0):
        said = estimated(knowledge, touch)
        assert said.ln_likelihood[:3].argmax() == number
        off = said.mean[number] - [touch.object_c - AMBIENT_C, np.log(touch.effusivity / PLATE_J_M2K)]
        zs.append(off / np.sqrt(np.diag(said.covariance[number])))
        misfits.append(said.misfit)
    # of 16 standard normal numbers 99.9 % have a mean square between 0.25 and 2.5
    assert 0.25 < np.mean(np.square(zs)) < 2.5
    assert 0.7 < np.mean(misfits) < 1.3


def test_all_temperatures_may_be_shifted(knowledge: ThermalKnowledge) -> None:
    touch = made_touches("plastic", 1, seed=2, seconds=1.0)[0]
    here, there = estimated(knowledge, touch), estimated(knowledge, touch, shift_c=-7.0)
    assert there.ln_likelihood == pytest.approx(here.ln_likelihood, abs=1e-6)
    assert there.mean == pytest.approx(here.mean, abs=1e-9)
    assert there.start_c == here.start_c - 7.0


@pytest.mark.long
def test_the_uncertainty_of_the_object_shrinks(knowledge: ThermalKnowledge) -> None:
    touch = made_touches("plastic", 1, seed=3, seconds=5.0)[0]
    sds = [np.sqrt(estimated(knowledge, touch.until(t)).covariance[2, 0, 0]) for t in (0.3, 1.0, 2.0, 5.0)]
    assert sds == sorted(sds, reverse=True)
    assert sds[-1] < 0.4 * sds[0]


def test_an_unexplained_touch_is_a_misfit(knowledge: ThermalKnowledge) -> None:
    touch = made_touches("stone", 1, seed=4, seconds=3.0)[0]
    jumped = replace(touch, sensor_c=np.where(touch.time_s > 1.0, touch.sensor_c - 3.0, touch.sensor_c))
    assert estimated(knowledge, jumped).misfit > 5.0
    assert estimated(knowledge, touch).misfit < 1.3


def test_a_pressure_that_changes_for_good_makes_the_contact_less_certain(
    knowledge: ThermalKnowledge, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What readings under another force say of the object is trusted less than if the law of the force were exact."""
    touch = made_touches("stone", 1, seed=8, seconds=3.0)[0]
    firmer = replace(touch, force_n=np.where(touch.time_s > 1.0, 3.0, touch.force_n))
    doubted = estimated(knowledge, firmer.until(1.3)).covariance[1, 1, 1]
    monkeypatch.setattr("remote_site.thermal.contact_change.UNSTEADY", 0.0)
    assert doubted > estimated(knowledge, firmer.until(1.3)).covariance[1, 1, 1]


def test_a_plate_that_was_still_warming_up_is_ahead_of_its_reading(knowledge: ThermalKnowledge) -> None:
    """At 2 K/s and a lag of 0.3 s the plate is 0.6 K warmer than it reads; unsaid, that would be no such object."""
    sensor_c = plate_courses(np.array([480.0]), np.array([900.0]), np.array([22.0]), np.array([33.6]), 2.0)[0]
    after_s = 0.01 * np.arange(1, len(sensor_c) + 1)
    time_s = np.append(-0.01, after_s)
    read_c = sensor_c - 0.6 * np.exp(-after_s / MADE_SENSOR.lag_s)
    noisy = np.append(33.0, measured(read_c, MADE_SENSOR, np.random.default_rng(0)))
    touch = MadeTouch("plastic", time_s, noisy, pressed()(time_s), 22.0, 480.0)
    warming, still = (estimated(knowledge, touch, slope_k_s) for slope_k_s in (2.0, 0.0))
    assert warming.ln_likelihood[2] > still.ln_likelihood[2] + 5.0
    assert abs(warming.mean[2, 0] - (22.0 - AMBIENT_C)) < 3.0 * np.sqrt(warming.covariance[2, 0, 0])


def test_rejected_substances_are_removed_completely(knowledge: ThermalKnowledge) -> None:
    """Not their improbability without their temperature: fingers would agree on what each of them finds absurd."""
    said = estimated(knowledge, made_touches("metal", 1, seed=6, seconds=3.0)[0])
    behind = said.ln_likelihood.max() - said.ln_likelihood
    assert (behind[1:3] > 20.0).all()
    assert behind.max() < 30.0
    assert np.isfinite(said.mean).all()
    assert (np.linalg.eigvalsh(said.covariance) > 0.0).all()
    given_up = said.ln_likelihood == said.ln_likelihood.min()
    assert given_up.sum() > 1
    assert (said.mean[given_up, 0] == 0.0).all()
    assert (said.covariance[given_up, 0, 0] == ANYWHERE_K**2).all()
    assert (said.covariance[given_up, 0, 1] == 0.0).all()


@pytest.mark.parametrize("name", MATERIALS)
def test_a_substance_outside_its_range_of_effusivities_is_excluded(knowledge: ThermalKnowledge, name: str) -> None:
    """Pushed there by the readings it is less exact than its neighbour; it has outvoted the right material by that."""
    known = knowledge.substances
    said = estimated(knowledge, second_of(name, -3.0))
    away = np.abs(said.mean[:, 1] - known.ln_effusivity) / np.sqrt(known.effusivity_variance)
    assert away[known.calibrated :].max() < 3.0
    lowest = said.ln_likelihood[known.calibrated :].min()
    assert said.ln_likelihood.max() - lowest == pytest.approx(FORGET, abs=1.0)
    nearest = np.abs(known.ln_effusivity - said.mean[knowledge.table.names().index(name), 1])
    nearest[: known.calibrated] = np.inf
    assert said.ln_likelihood[nearest.argmin()] > lowest
