"""What all calibration touches say together: constants of the sensor, and a population for each material.

Every touch has its own effusivity, conductance and lag, drawn from normals in their logarithms, and its own
temperatures of plate and back. Each round linearises the model of all touches at once around its present guess, solves
each touch with its population as the prior, solves the sensor's constants from what all touches leave (eliminating the
touches' own numbers exactly), and takes the populations anew from the touches (expectation-maximisation).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remote_site.touch_model import COURSES, PLATE_J_M2K, Contacts, SensorConstants, TouchModel

Array = NDArray[np.float64]

ROUNDS = 80
"""At most: leak, effusivities and conductances trade against each other and settle together, slowly."""
SETTLED = 0.002
"""Change of any constant's logarithm in a round below which the fit has settled."""
SETTLED_ROUNDS = 4
"""Populations keep their first width for so long: means have to settle before scatter can be told from error."""
SLAB_ROUNDS = (5, 10, 15, 20)
"""Effusivity and thickness trade against each other: each choice of slabs is made again once the rest has followed."""
SLABS_S = (np.inf, 30.0, 20.0, 14.0, 10.0, 7.0, 5.0, 3.5, 2.5, 1.7, 1.2, 0.8, 0.6, 0.4, 0.3)
SLAB_GAIN = 6.0
"""A slab has to explain a material's touches better than a half space by this much, in ln probability."""
EACH_UNTIL = 60
"""Readings after contact that count one by one; later ones are averaged by BLOCK."""
BLOCK = 4
READING_S = 0.01
FIRST = (np.log(800.0 / PLATE_J_M2K), np.log(0.6), np.log(0.3))
"""Where every touch begins: ln effusivity, ln conductance, ln lag."""
FIRST_SD = (1.0, 0.15, 0.2)
PRIOR_TOUCHES = (1.0, 10.0, 4.0)
"""Weight of the usual scatter beside a population's own, in touches."""
USUAL_SD = (0.05, 0.15, 0.2)
LEAST_LAG_SD = 0.05
NOT_WHITE = 1.4
"""What a model leaves is not white: taken as white noise it counts for so much more. With this, the temperatures of
simulated touches that calibrated nothing come out as far off as their standard deviations say."""
LEAST_BACK_SD_K = 0.3
LEAST_START_SD_K = 0.03
KNOWN_OBJECT_SD_K = 0.03
"""Of an object's temperature that was measured, K."""
LEAK_LN_SD, FORCE_LN_SD = 0.5, 1.0
HALF_FORCE_N = 0.3
LARGEST_STEP = 0.7
_GLOBAL_STEP = 0.05


@dataclass(frozen=True, slots=True)
class CalibrationTouch:
    """One labelled touch, readings at 100 Hz from the first after contact.

    Attributes:
        material: index of its material.
        reading_c: (k,) C.
        force_n: (k,) N.
        start_c: reading at contact, C.
        slope_k_s: its slope just before, K/s.
        ambient_c: ambient temperature, C.
        object_c: of the object, C.
        object_sd_k: how well that is known, K.
    """

    material: int
    reading_c: Array
    force_n: Array
    start_c: float
    slope_k_s: float
    ambient_c: float
    object_c: float
    object_sd_k: float = KNOWN_OBJECT_SD_K


@dataclass(frozen=True, slots=True)
class Population:
    """Result of the fit; per material (m, ...).

    Attributes:
        leak_per_s, half_force_n, back_share, back_sd_k, start_sd_k, ln_lag, ln_lag_sd, noise_k: see `MaterialTable`.
        mean: (m, 2) of ln effusivity and ln conductance.
        covariance: (m, 2, 2).
        slab_s: (m,) infinite for a half space.
        misfit: (m,) mean square of the residuals over the noise's variance.
        residual_k: (touches, k) what the model leaves, K.
        object_k: (touches,) object temperature above ambient as the fit has it, K.
    """

    leak_per_s: float
    half_force_n: float
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


class PopulationFit:
    """The fit's state, round by round."""

    def __init__(self, touches: Sequence[CalibrationTouch], materials: int, leak_per_s: float) -> None:
        """Begin.

        Args:
            touches: all of them; their common length counts.
            materials: number of materials; each needs two touches or more.
            leak_per_s: rate of a free cool-down, 1/s: a first guess of the leak.
        """
        length = min(len(touch.reading_c) for touch in touches)
        edges = _edges(length)
        self.count = np.diff(edges).astype(np.float64)
        self.material = np.array([touch.material for touch in touches])
        start = np.array([touch.start_c for touch in touches])
        self.reading_k = _means(np.stack([touch.reading_c[:length] for touch in touches]), edges) - start[:, None]
        self.force_n = _means(np.stack([touch.force_n[:length] for touch in touches]), edges)
        self.slope_k_s = np.array([touch.slope_k_s for touch in touches])
        self.ambient_k = np.array([touch.ambient_c for touch in touches]) - start
        self.object_k = np.array([touch.object_c for touch in touches]) - start
        self.object_sd_k = np.array([touch.object_sd_k for touch in touches])
        n = len(touches)
        self.own = np.tile(FIRST, (n, 1))
        self.mean = np.tile(FIRST[:2], (materials, 1))
        self.covariance = np.tile(np.diag(np.square(FIRST_SD[:2])), (materials, 1, 1))
        self.lag = (FIRST[2], FIRST_SD[2])
        self.slab_s = np.full(materials, np.inf)
        self.leak_prior = np.log([max(leak_per_s, 1e-3), HALF_FORCE_N])
        self.sensor = self.leak_prior.copy()
        self.back_share, self.back_sd_k, self.start_sd_k = 0.3, 1.5, 0.15
        self.noise_k = 0.05
        self.difference_k = -self.object_k
        self.residual_k = np.zeros_like(self.reading_k)
        self.solved_k = self.object_k.copy()

    @property
    def times_s(self) -> Array:
        """Times after contact of the readings that are fitted: the middles of their blocks, s."""
        return np.asarray((np.cumsum(self.count) - 0.5 * (self.count - 1.0)) * READING_S)

    def run(self) -> Population:
        """All rounds."""
        for number in range(ROUNDS):
            if number in SLAB_ROUNDS:
                self._choose_slabs()
            before = np.concatenate((self.sensor, self.mean.ravel()))
            self._round(number)
            moved = np.abs(np.concatenate((self.sensor, self.mean.ravel())) - before).max()
            if number > max(SLAB_ROUNDS) and moved < SETTLED:
                break
        late = self.residual_k**2 * self.count * (NOT_WHITE / self.noise_k) ** 2
        misfit = np.array([late[self.material == m].mean() for m in range(len(self.mean))])
        return Population(
            leak_per_s=float(np.exp(self.sensor[0])),
            half_force_n=float(np.exp(self.sensor[1])),
            back_share=self.back_share,
            back_sd_k=self.back_sd_k,
            start_sd_k=self.start_sd_k,
            ln_lag=self.lag[0],
            ln_lag_sd=self.lag[1],
            noise_k=self.noise_k,
            mean=self.mean,
            covariance=self.covariance,
            slab_s=self.slab_s,
            misfit=misfit,
            residual_k=self.residual_k,
            object_k=self.solved_k - self.ambient_k,
        )

    def _courses(self, sensor: Array, slab_s: Array) -> Array:
        """Courses of all touches, (touches, k, 6); slopes scaled by each touch's difference."""
        constants = SensorConstants(float(np.exp(sensor[0])), float(np.exp(sensor[1])))
        contacts = Contacts(self.own[:, 0], self.own[:, 1], slab_s[self.material])
        model = TouchModel(constants, contacts, np.arange(len(self.own)), self.own[:, 2])
        courses = np.empty((*self.reading_k.shape, COURSES))
        for k, count in enumerate(self.count):
            if count == 1.0:
                model.step(READING_S, self.force_n[:, k])
                courses[:, k] = model.courses
                continue
            # a mean over readings is the reading at their middle
            middle = 0.5 * (count + 1.0) * READING_S
            model.step(middle, self.force_n[:, k])
            courses[:, k] = model.courses
            model.step(count * READING_S - middle, self.force_n[:, k])
        least = np.where(np.abs(self.difference_k) < 0.5, 0.5, self.difference_k)
        courses[:, :, 3:] *= least[:, None, None]
        return courses

    def _prior(self) -> tuple[Array, Array]:
        """Means (touches, 6) and precisions (touches, 6, 6) of the touches' own numbers."""
        n = len(self.own)
        mean, precision = np.zeros((n, 6)), np.zeros((n, 6, 6))
        mean[:, 0], precision[:, 0, 0] = self.object_k, self.object_sd_k**-2
        mean[:, 1], precision[:, 1, 1] = self.slope_k_s * np.exp(self.own[:, 2]), self.start_sd_k**-2
        mean[:, 2], precision[:, 2, 2] = (1.0 - self.back_share) * self.ambient_k, self.back_sd_k**-2
        mean[:, 3:5] = self.mean[self.material] - self.own[:, :2]
        precision[:, 3:5, 3:5] = np.linalg.inv(self.covariance)[self.material]
        mean[:, 5], precision[:, 5, 5] = self.lag[0] - self.own[:, 2], self.lag[1] ** -2
        return mean, precision

    def _solve(self, courses: Array) -> tuple[Array, Array]:
        """Most probable own numbers (touches, 6) and their covariances."""
        weight = self.count / self.noise_k**2
        mean, precision = self._prior()
        normal = np.einsum("nki,k,nkj->nij", courses, weight, courses) + precision
        right = np.einsum("nki,k,nk->ni", courses, weight, self.reading_k) + np.einsum("nij,nj->ni", precision, mean)
        covariance = np.linalg.inv(normal)
        return np.einsum("nij,nj->ni", covariance, right), covariance

    def _round(self, number: int) -> None:
        courses = self._courses(self.sensor, self.slab_s)
        solved, covariance = self._solve(courses)
        self.residual_k = self.reading_k - np.einsum("nki,ni->nk", courses, solved)
        solved = self._move_sensor(courses, solved, covariance)
        self.own = self.own + np.clip(solved[:, 3:], -LARGEST_STEP, LARGEST_STEP)
        self.difference_k = solved[:, 1] - solved[:, 0]
        self.solved_k = solved[:, 0]
        self._take_populations(solved, covariance, settled=number >= SETTLED_ROUNDS)
        self.noise_k = NOT_WHITE * float(np.sqrt(np.mean(self.residual_k**2 * self.count)))

    def _move_sensor(self, courses: Array, solved: Array, covariance: Array) -> Array:
        """One Gauss-Newton step of the sensor's two constants; returns the touches' own numbers with it."""
        weight = self.count / self.noise_k**2
        slopes = np.stack(
            [
                (self._courses(self.sensor + step, self.slab_s)[..., :3] - courses[..., :3]) / _GLOBAL_STEP
                for step in np.eye(2) * _GLOBAL_STEP
            ],
            axis=-1,
        )
        along = np.einsum("nkig,ni->nkg", slopes, solved[:, :3])
        mixed = np.einsum("nki,k,nkg->nig", courses, weight, along)
        normal = np.einsum("nkg,k,nkh->gh", along, weight, along)
        normal -= np.einsum("nig,nij,njh->gh", mixed, covariance, mixed)
        right = np.einsum("nkg,k,nk->g", along, weight, self.residual_k)
        prior = np.diag([LEAK_LN_SD**-2, FORCE_LN_SD**-2])
        step = np.linalg.solve(normal + prior, right + prior @ (self.leak_prior - self.sensor))
        step = np.clip(step, -0.4, 0.4)
        self.sensor = self.sensor + step
        return np.asarray(solved - np.einsum("nij,njg,g->ni", covariance, mixed, step))

    def _take_populations(self, solved: Array, covariance: Array, *, settled: bool) -> None:
        weight = np.array(PRIOR_TOUCHES)
        usual = weight * np.square(USUAL_SD)
        pairs = np.sqrt(np.outer(weight[:2], weight[:2]))
        for m in range(len(self.mean)):
            mine = self.material == m
            own = self.own[mine, :2]
            self.mean[m] = own.mean(axis=0)
            if settled:
                away = own - self.mean[m]
                scatter = np.diag(usual[:2]) + away.T @ away + covariance[mine][:, 3:5, 3:5].sum(axis=0)
                # what another touch will be like is less certain than what these were like
                wider = (mine.sum() + 2.0) / max(mine.sum() - 2.0, 1.0)
                self.covariance[m] = scatter / (mine.sum() + pairs) * wider
        lag = self.own[:, 2]
        around = float(lag.mean())
        if settled:
            square = np.sum((lag - around) ** 2 + covariance[:, 5, 5]) + usual[2]
            self.lag = (around, max(float(np.sqrt(square / (len(lag) + weight[2]))), LEAST_LAG_SD))
        else:
            self.lag = (around, FIRST_SD[2])
        plate_k, back_k = -self.ambient_k, solved[:, 2] - self.ambient_k
        self.back_share = float(plate_k @ back_k / (plate_k @ plate_k))
        rest = (back_k - self.back_share * plate_k) ** 2 + covariance[:, 2, 2]
        self.back_sd_k = max(float(np.sqrt(rest.mean())), LEAST_BACK_SD_K)
        rest = (solved[:, 1] - self.slope_k_s * np.exp(lag)) ** 2 + covariance[:, 1, 1]
        self.start_sd_k = max(float(np.sqrt(rest.mean())), LEAST_START_SD_K)

    def _choose_slabs(self) -> None:
        """Whether a material's pieces are so thin that their back is felt."""
        misfits = []
        expected, precision = self._prior()
        for slab_s in SLABS_S:
            courses = self._courses(self.sensor, np.full(len(self.mean), slab_s))
            solved, covariance = self._solve(courses)
            residual = self.reading_k - np.einsum("nki,ni->nk", courses, solved)
            square = (residual**2 * self.count).sum(axis=1) / self.noise_k**2
            off = solved - expected
            square += np.einsum("ni,nij,nj->n", off, precision, off) - np.linalg.slogdet(covariance)[1]
            misfits.append([0.5 * square[self.material == m].sum() for m in range(len(self.mean))])
        misfit = np.array(misfits)
        best = misfit.argmin(axis=0)
        gained = misfit[0] - misfit.min(axis=0) > SLAB_GAIN
        self.slab_s = np.where(gained, np.array(SLABS_S)[best], np.inf)


def _edges(length: int) -> NDArray[np.intp]:
    """Where the blocks of readings begin, and where the last ends."""
    late = np.arange(min(EACH_UNTIL, length), length + 1, BLOCK)
    return np.concatenate((np.arange(min(EACH_UNTIL, length)), late)).astype(np.intp)


def _means(values: Array, edges: NDArray[np.intp]) -> Array:
    """Means of (touches, readings) over blocks."""
    sums = np.concatenate((np.zeros((len(values), 1)), np.cumsum(values, axis=1)), axis=1)
    return np.asarray((sums[:, edges[1:]] - sums[:, edges[:-1]]) / np.diff(edges))
