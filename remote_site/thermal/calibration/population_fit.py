"""Fits the constants of the sensor, and a population for each material, to all calibration touches together.

Every touch has its own effusivity, conductance and lag, drawn from normal distributions of their logarithms, and its
own temperatures of plate and back. Each round linearises the model of all touches around the present estimate. It then
takes one damped Gauss-Newton step of all parameters. These are the touches' own parameters, with their population as
the prior, and the shared parameters (the sensor's constants and the populations' means). After the step, the touches
give a new scatter of the populations (expectation-maximisation), and the residuals give the noise.

The fit has several optima. In wrong ones, every touch has another lag. It therefore begins more than once, and the
beginning that is more probable after COMPARED_ROUNDS continues.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from common.runtime.parallel_map import Map, Progress, unseen
from remote_site.thermal.calibration.calibration_touches import UNKNOWN_OBJECT_SD_K, CalibrationReadings
from remote_site.thermal.calibration.population_prior import (
    BACK_SHARE,
    COMMON,
    EARLY_UNIT_S,
    FIRST,
    FIRST_LAG_SDS,
    FIRST_SD,
    LEAST_BACK_SD_K,
    LEAST_LAG_SD,
    LEAST_START_SD_K,
    PRIOR_TOUCHES,
    SENSOR,
    T_FREEDOM,
    T_SCALE_K,
    USUAL_SD,
    common_prior,
    usual_sensor,
)
from remote_site.thermal.touch_model import COURSES, Contacts, SensorConstants, TouchModel

Array = NDArray[np.float64]

ROUNDS = 80
"""Maximum number of rounds."""
COMPARED_ROUNDS = 25
"""Number of rounds of each beginning."""
SETTLED = 0.002
"""Change of any constant's logarithm in a round below which the fit has settled."""
SETTLED_ROUNDS = 7
"""Number of rounds in which populations keep their first width; means must settle before scatter can be estimated."""
SLAB_ROUNDS = (7, 12, 17, 22)
"""Rounds in which the slabs are chosen again, since effusivity and thickness compensate each other."""
SLABS_S = (np.inf, 30.0, 20.0, 14.0, 10.0, 7.0, 5.0, 3.5, 2.5, 1.7, 1.2, 0.8, 0.6, 0.4, 0.3)
"""Values of thickness^2 / diffusivity to choose from, s; infinite for a half space."""
SLAB_GAIN = 6.0
"""Minimum gain in ln probability of a material's touches for a slab instead of a half space."""
COLOURED = 40
"""Number of neighbouring residuals in the means that also set the noise, because residuals are not white."""
LARGEST_STEP = 0.7
"""Largest change of a parameter in one step."""
LEAST_DAMPING, LARGEST_DAMPING = 1e-4, 1e3
"""Range of the damping of a Gauss-Newton step (Levenberg 1944, Marquardt 1963); far from the solution it overshoots."""
TRIES = 5
"""Maximum number of attempts at one step."""
_GLOBAL_STEP = 0.05
"""Change of a sensor parameter from which its slopes are computed."""


@dataclass(frozen=True, slots=True)
class Population:
    """Result of the fit; arrays of the m materials begin with (m, ...).

    Attributes:
        sensor: constants of the sensor.
        back_share, back_sd_k, start_sd_k, ln_lag, ln_lag_sd, noise_k: see `MaterialTable`.
        mean: (m, 2) mean of ln effusivity and ln conductance.
        covariance: (m, 2, 2) covariance of both.
        slab_s: (m,) thickness^2 / diffusivity, s; infinite for a half space.
        misfit: (m,) mean square of the residuals, over that expected with this noise.
        residual_k: (touches, k) residuals of the model, K.
        object_k: (touches,) fitted object temperature above ambient, K.
        object_sd_k: (touches,) standard deviation of the object temperature, K.
    """

    sensor: SensorConstants
    back_share: float
    back_sd_k: float
    start_sd_k: float
    ln_lag: float
    ln_lag_sd: float
    noise_k: float
    mean: Array
    covariance: Array
    slab_s: Array
    misfit: Array
    residual_k: Array
    object_k: Array
    object_sd_k: Array


def fit_populations(
    seen: CalibrationReadings,
    materials: int,
    leak_per_s: float,
    mapped: Map = map,
    progress: Progress = unseen,
) -> Population:
    """Fit sensor and populations to touches.

    Args:
        seen: readings of all touches.
        materials: number of materials; each needs two touches or more.
        leak_per_s: rate of a free cool-down, 1/s: the initial value of the leak.
        mapped: the function `map`, or a parallel one, that computes courses; the result does not depend on it.
        progress: is called with the completed share of all possible rounds.
    """
    fits = [PopulationFit(seen, materials, leak_per_s, lag_sd, mapped) for lag_sd in FIRST_LAG_SDS]
    before = COMPARED_ROUNDS * (len(fits) - 1)
    for number, fit in enumerate(fits):
        for done in fit.rounds(COMPARED_ROUNDS):
            progress((COMPARED_ROUNDS * number + done) / (before + ROUNDS))
    best = min(fits, key=PopulationFit.unlikely)
    for done in best.rounds(ROUNDS):
        progress((before + done) / (before + ROUNDS))
    return best.population()


class PopulationFit:
    """State of one fit, round by round."""

    def __init__(
        self, seen: CalibrationReadings, materials: int, leak_per_s: float, lag_sd: float, mapped: Map
    ) -> None:
        """Begin; `lag_sd` is the initial scatter of the touches in ln lag. See `fit_populations`."""
        self._mapped = mapped
        self.seen = seen
        self.object_sd_k = seen.object_sd_k
        self.unknown = seen.object_sd_k >= UNKNOWN_OBJECT_SD_K
        n = len(seen.reading_k)
        self.own = np.tile(FIRST, (n, 1))
        self.mean = np.tile(FIRST[:2], (materials, 1))
        self.covariance = np.tile(np.diag(np.square(FIRST_SD)), (materials, 1, 1))
        self.lag = (FIRST[2], lag_sd)
        self.slab_s = np.full(materials, np.inf)
        self.sensor_prior = usual_sensor(leak_per_s)
        self.sensor = self.sensor_prior
        self.back_share, self.back_sd_k, self.start_sd_k = BACK_SHARE, 0.3, 0.1
        self.noise_k = 0.05
        self.misfit = np.ones(materials)
        self.damping = 0.1
        self.difference_k = -seen.object_k
        self.residual_k = np.zeros_like(seen.reading_k)
        self.solved = np.zeros((n, 3))
        self._done, self._settled = 0, False
        """Number of rounds, and whether the last one changed nothing."""

    def rounds(self, until: int) -> Iterator[int]:
        """Run rounds until their number is `until` or the fit has settled; yield the number before each."""
        while self._done < until and not self._settled:
            yield self._done
            if self._done in SLAB_ROUNDS:
                self._choose_slabs()
            before = np.concatenate((self.sensor, self.mean.ravel()))
            self._round(self._done)
            moved = np.abs(np.concatenate((self.sensor, self.mean.ravel())) - before).max()
            self._settled = self._done > max(SLAB_ROUNDS) and bool(moved < SETTLED)
            self._done += 1

    def unlikely(self) -> float:
        """Return twice the negative ln probability of the readings, up to a constant (Laplace's approximation)."""
        (courses,) = self._courses((self.sensor, self.slab_s))
        weight = self.seen.count / self.noise_k**2
        prior = self._prior()[1]
        normal = np.einsum("nki,k,nkj->nij", courses, weight, courses) + prior
        spread = np.linalg.slogdet(normal)[1].sum() - np.linalg.slogdet(prior)[1].sum()
        return float(self._cost(courses) + spread + 2.0 * self.seen.reading_k.size * np.log(self.noise_k))

    def population(self) -> Population:
        """Return the present estimate."""
        return Population(
            sensor=_constants(self.sensor),
            back_share=self.back_share,
            back_sd_k=self.back_sd_k,
            start_sd_k=self.start_sd_k,
            ln_lag=self.lag[0],
            ln_lag_sd=self.lag[1],
            noise_k=self.noise_k,
            mean=self.mean,
            covariance=self.covariance,
            slab_s=self.slab_s,
            misfit=self.misfit,
            residual_k=self.residual_k,
            object_k=self.solved[:, 0] - self.seen.ambient_k,
            object_sd_k=self.solved_sd_k,
        )

    def _courses(self, *ways: tuple[Array, Array]) -> Iterable[Array]:
        """Return the courses of all touches, for each pair of sensor parameters and slabs of the materials."""
        made = partial(_courses, self.seen, self.own, self.difference_k)
        return self._mapped(made, ways) if len(ways) > 1 else map(made, ways)

    def _prior(self) -> tuple[Array, Array]:
        """Return prior means (touches, 6) and precisions (touches, 6, 6) of the touches' own parameters."""
        n = len(self.own)
        mean, precision = np.zeros((n, 6)), np.zeros((n, 6, 6))
        mean[:, 0], precision[:, 0, 0] = self.seen.object_k, self.object_sd_k**-2
        mean[:, 1], precision[:, 1, 1] = self.seen.slope_k_s * np.exp(self.own[:, 2]), self.start_sd_k**-2
        mean[:, 2], precision[:, 2, 2] = (1.0 - self.back_share) * self.seen.ambient_k, self.back_sd_k**-2
        mean[:, 3:5] = self.mean[self.seen.material] - self.own[:, :2]
        precision[:, 3:5, 3:5] = np.linalg.inv(self.covariance)[self.seen.material]
        mean[:, 5], precision[:, 5, 5] = self.lag[0] - self.own[:, 2], self.lag[1] ** -2
        return mean, precision

    def _solve(self, courses: Array) -> tuple[Array, Array]:
        """Return the touches' most probable own parameters (touches, 6) and their covariances."""
        weight = self.seen.count / self.noise_k**2
        mean, precision = self._prior()
        normal = np.einsum("nki,k,nkj->nij", courses, weight, courses) + precision
        right = np.einsum("nki,k,nk->ni", courses, weight, self.seen.reading_k) + np.einsum(
            "nij,nj->ni", precision, mean
        )
        covariance = np.linalg.inv(normal)
        return np.einsum("nij,nj->ni", covariance, right), covariance

    def _round(self, number: int) -> None:
        """Take one step, damped until it fits the touches better; then update scatter and noise."""
        (courses,) = self._courses((self.sensor, self.slab_s))
        before = self._cost(courses)
        along = self._sensor_slopes(courses)
        kept = self._state()
        for _ in range(TRIES):
            covariance = self._step(courses, along)
            now = self._cost(*self._courses((self.sensor, self.slab_s)))
            if now < before:
                self.damping = max(self.damping / 4.0, LEAST_DAMPING)
                break
            self._restore(kept)
            self._cost(courses)
            self.damping = min(self.damping * 4.0, LARGEST_DAMPING)
        self._take_object_sd(covariance)
        if number >= SETTLED_ROUNDS:
            self._take_scatter(covariance)
        self._take_noise(courses, covariance)

    def _state(self) -> tuple[Array, Array, float, float, Array, Array]:
        """Return the state that a step changes."""
        return self.own, self.sensor, self.lag[0], self.back_share, self.mean, self.difference_k

    def _restore(self, state: tuple[Array, Array, float, float, Array, Array]) -> None:
        self.own, self.sensor, lag, self.back_share, self.mean, self.difference_k = state
        self.lag = (lag, self.lag[1])

    def _temperatures(self, courses: Array) -> Array:
        """Return the most probable temperatures of object, plate and back, (touches, 3), with all else unchanged."""
        weight = self.seen.count / self.noise_k**2
        mean, precision = self._prior()
        mean, precision = mean[:, :3], precision[:, :3, :3]
        normal = np.einsum("nki,k,nkj->nij", courses[..., :3], weight, courses[..., :3]) + precision
        right = np.einsum("nki,k,nk->ni", courses[..., :3], weight, self.seen.reading_k)
        right += np.einsum("nij,nj->ni", precision, mean)
        solved = np.linalg.solve(normal, right[..., None])[..., 0]
        self.residual_k = self.seen.reading_k - np.einsum("nki,ni->nk", courses[..., :3], solved)
        self.solved = solved
        self.difference_k = solved[:, 1] - solved[:, 0]
        return np.asarray(solved)

    def _cost(self, courses: Array) -> float:
        """Return twice the negative ln probability of readings and parameters, up to a constant."""
        solved = self._temperatures(courses)
        mean, precision = self._prior()
        away = np.concatenate((solved, np.zeros((len(solved), 3))), axis=1) - mean
        usual, prior = common_prior(self.sensor_prior, len(self.mean))
        off = self._common() - usual
        cost = (self.residual_k**2 * self.seen.count).sum() / self.noise_k**2
        return float(cost + np.einsum("ni,nij,nj->", away, precision, away) + off @ prior @ off)

    def _common(self) -> Array:
        """Return the parameters that touches share, with the populations' means last."""
        return np.concatenate((self.sensor, [self.lag[0], self.back_share], self.mean.ravel()))

    def _sensor_slopes(self, courses: Array) -> Array:
        """Return slopes of all readings by the shared parameters, (touches, k, COMMON + 2 m).

        Only the slopes by the sensor's parameters differ from 0.
        """
        slopes = np.zeros((*self.seen.reading_k.shape, COMMON + 2 * len(self.mean)))
        others = self._courses(*((self.sensor + step, self.slab_s) for step in np.eye(SENSOR) * _GLOBAL_STEP))
        for k, other in enumerate(others):
            moved = (other[..., :3] - courses[..., :3]) / _GLOBAL_STEP
            slopes[..., k] = np.einsum("nki,ni->nk", moved, self.solved)
        return slopes

    def _step(self, courses: Array, along: Array) -> Array:
        """Take one damped Gauss-Newton step of all parameters; return the covariances of the touches' own parameters.

        The shared constants of the sensor act on the readings. The shared means of the populations act on the touches'
        priors. One step changes both, with the touches eliminated, so that neither compensates an error of the other.
        """
        weight = self.seen.count / self.noise_k**2
        own = np.concatenate((self.solved, np.zeros((len(self.solved), 3))), axis=1)
        materials = len(self.mean)
        common = COMMON + 2 * materials
        shift = np.zeros((len(own), 6, common))
        shift[:, 5, SENSOR] = 1.0
        shift[:, 2, SENSOR + 1] = -self.seen.ambient_k
        rows = np.arange(len(own))
        shift[rows, 3, COMMON + 2 * self.seen.material] = 1.0
        shift[rows, 4, COMMON + 1 + 2 * self.seen.material] = 1.0
        mean, precision = self._prior()
        pull = np.einsum("nij,njg->nig", precision, shift)
        normal = np.einsum("nki,k,nkj->nij", courses, weight, courses) + precision
        covariance = np.linalg.inv(normal)
        damped = normal.copy()
        damped[:, (3, 4, 5), (3, 4, 5)] *= 1.0 + self.damping
        damped = np.linalg.inv(damped)
        right = np.einsum("nki,k,nk->ni", courses, weight, self.residual_k)
        right += np.einsum("nij,nj->ni", precision, mean - own)
        mixed = np.einsum("nki,k,nkg->nig", courses, weight, along) - pull
        shared = np.einsum("nkg,k,nkh->gh", along, weight, along) + np.einsum("nig,nih->gh", shift, pull)
        usual, prior = common_prior(self.sensor_prior, len(self.mean))
        shared += prior
        shared[np.diag_indices(common)] *= 1.0 + self.damping
        shared -= np.einsum("nig,nij,njh->gh", mixed, damped, mixed)
        push = np.einsum("nkg,k,nk->g", along, weight, self.residual_k)
        push += np.einsum("nig,ni->g", pull, own - mean) + prior @ (usual - self._common())
        push -= np.einsum("nig,nij,nj->g", mixed, damped, right)
        step = np.linalg.solve(shared, push)
        moved = np.einsum("nij,nj->ni", damped, right - np.einsum("nig,g->ni", mixed, step))
        length = min(1.0, LARGEST_STEP / max(np.abs(step).max(), np.abs(moved[:, 3:]).max()))
        now = self._common() + length * step
        self.own = self.own + length * moved[:, 3:]
        self.sensor, self.back_share = now[:SENSOR], float(now[SENSOR + 1])
        self.lag = (float(now[SENSOR]), self.lag[1])
        self.mean = now[COMMON:].reshape(materials, 2)
        return covariance

    def _take_object_sd(self, covariance: Array) -> None:
        """Set the standard deviation of unknown object temperatures by the expected precision of Student's t.

        Most of these objects are near ambient, and few are far from it.
        """
        self.solved_sd_k = np.sqrt(covariance[:, 0, 0])
        square = (self.solved[:, 0] - self.seen.object_k) ** 2 + covariance[:, 0, 0]
        wide = np.sqrt((T_FREEDOM * T_SCALE_K**2 + square) / (T_FREEDOM + 1.0))
        self.object_sd_k = np.where(self.unknown, wide, self.object_sd_k)

    def _take_scatter(self, covariance: Array) -> None:
        """Update the scatter of the touches around the means of their populations."""
        weight = np.array(PRIOR_TOUCHES)
        usual = weight * np.square(USUAL_SD)
        for m in range(len(self.mean)):
            mine = self.seen.material == m
            self.covariance[m] = population_scatter(self.own[mine, :2] - self.mean[m], covariance[mine][:, 3:5, 3:5])
        square = np.sum((self.own[:, 2] - self.lag[0]) ** 2 + covariance[:, 5, 5]) + usual[2]
        width = float(np.sqrt(square / (len(self.own) + weight[2])))
        self.lag = (self.lag[0], max(width, LEAST_LAG_SD))
        back_k = self.solved[:, 2] - (1.0 - self.back_share) * self.seen.ambient_k
        rest = back_k**2 + covariance[:, 2, 2]
        self.back_sd_k = max(float(np.sqrt(rest.mean())), LEAST_BACK_SD_K)
        rest = (self.solved[:, 1] - self.seen.slope_k_s * np.exp(self.own[:, 2])) ** 2 + covariance[:, 1, 1]
        self.start_sd_k = max(float(np.sqrt(rest.mean())), LEAST_START_SD_K)

    def _take_noise(self, courses: Array, covariance: Array) -> None:
        """Update the noise from single residuals or from means over many, whichever is larger."""
        weight = np.sqrt(self.seen.count) / self.noise_k
        left, weighed = self.residual_k * weight, courses * weight[:, None]
        found = []
        for each in (1, min(COLOURED, len(weight))):
            blocks = len(weight) // each
            sums = left[:, : blocks * each].reshape(len(left), blocks, each).sum(axis=2) / np.sqrt(each)
            slopes = weighed[:, : blocks * each].reshape(len(left), blocks, each, COURSES).sum(axis=2) / np.sqrt(each)
            # each touch's own parameters have absorbed a part of the residuals
            expected = blocks - np.einsum("nbi,nij,nbj->n", slopes, covariance, slopes, optimize=True)
            total = np.bincount(self.seen.material, (sums**2).sum(axis=1)), np.bincount(self.seen.material, expected)
            found.append((total[0].sum() / total[1].sum(), total[0] / total[1]))
        excess, each_excess = max(found, key=lambda pair: float(pair[0]))
        self.misfit = np.asarray(each_excess / excess)
        self.noise_k *= float(np.sqrt(excess))

    def _choose_slabs(self) -> None:
        """Choose for each material a half space, or a slab if its pieces are so thin that their back has an effect."""
        misfits = []
        expected, precision = self._prior()
        for courses in self._courses(*((self.sensor, np.full(len(self.mean), slab_s)) for slab_s in SLABS_S)):
            solved, covariance = self._solve(courses)
            residual = self.seen.reading_k - np.einsum("nki,ni->nk", courses, solved)
            square = (residual**2 * self.seen.count).sum(axis=1) / self.noise_k**2
            off = solved - expected
            square += np.einsum("ni,nij,nj->n", off, precision, off) - np.linalg.slogdet(covariance)[1]
            misfits.append([0.5 * square[self.seen.material == m].sum() for m in range(len(self.mean))])
        misfit = np.array(misfits)
        best = misfit.argmin(axis=0)
        gained = misfit[0] - misfit.min(axis=0) > SLAB_GAIN
        self.slab_s = np.where(gained, np.array(SLABS_S)[best], np.inf)


def population_scatter(away: Array, covariance: Array) -> Array:
    """Return the covariance of ln effusivity and ln conductance of the next touch of a material, (2, 2).

    `away` (touches, 2) is the difference from the material's mean; `covariance` (touches, 2, 2) its uncertainty.
    """
    weight, count = np.array(PRIOR_TOUCHES[:2]), len(away)
    usual = np.diag(weight * np.square(USUAL_SD[:2]))
    scatter = usual + away.T @ away + covariance.sum(axis=0)
    # the product of two roots keeps the correlation below 1
    counted = np.sqrt(np.outer(count + weight, count + weight))
    # the prediction of another touch is less certain than the scatter of these
    wider = (count + 2.0) / max(count - 2.0, 1.0)
    return np.asarray(scatter / counted * wider)


def _courses(seen: CalibrationReadings, own: Array, difference_k: Array, way: tuple[Array, Array]) -> Array:
    """Return the courses of all touches, (touches, k, 6), with slopes scaled by each touch's difference.

    Args:
        seen: the touches.
        own: (touches, 3) ln of their own effusivity, conductance and lag.
        difference_k: (touches,) difference between plate and object, K.
        way: parameters of the sensor, and the slab of each material, s.
    """
    sensor, slab_s = way
    contacts = Contacts(own[:, 0], own[:, 1], slab_s[seen.material])
    model = TouchModel(_constants(sensor), contacts, np.arange(len(own)), own[:, 2])
    steps_s, of_step, ends = seen.steps
    courses = np.ascontiguousarray(model.advance(steps_s, seen.force_n.T[of_step])[ends].transpose(2, 0, 1))
    least = np.where(np.abs(difference_k) < 0.5, 0.5, difference_k)
    courses[:, :, 3:] *= least[:, None, None]
    return courses


def _constants(sensor: Array) -> SensorConstants:
    """Return the sensor's constants from the fitted parameters."""
    leak_per_s, half_force_n, _, power = (float(value) for value in np.exp(sensor))
    return SensorConstants(leak_per_s, half_force_n, EARLY_UNIT_S * float(sensor[2]), power)
