"""Estimates one touch from one finger's readings; each hypothesis is solved separately.

Each hypothesis has six unknown parameters: the temperatures of object, plate and back at contact, and the hypothesis's
offsets in the logarithms of effusivity, conductance and lag. A reading is linear in the three temperatures and in the
products of the three offsets with the difference between plate and object. Sums over the readings therefore hold all of
their information. A Kalman filter would fix the linearisation of each reading at the estimate of its time. Gauss-Newton
steps, 50 per second at first and 10 later, find the most probable parameters. Laplace's approximation there gives the
weights of the hypotheses. The readings between two steps are summed at once. A few times during a touch, all readings
are summed again around the present parameters of each hypothesis.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.contact_change import NEARLY_S, ContactChange
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.normal_equations import PLATE, NormalEquations, Reading
from remote_site.thermal.solving_turns import NOTHING_DUE, POSTPONED_S
from remote_site.thermal.touch_hypotheses import Substances, TouchHypotheses
from remote_site.thermal.touch_model import BLOCK, Contacts, SensorConstants

Array = NDArray[np.float64]

ANYWHERE_K = 10.0
"""Prior standard deviation of object temperatures around ambient, K."""
FORGET = 25.0
"""Distance below the best hypothesis in ln probability beyond which one may be dropped."""
PATIENCE = 20
"""Number of consecutive comparisons beyond FORGET before a hypothesis is dropped; later steps correct an overshoot."""
FEW = 80
"""Number of hypotheses up to which all are solved at once; half of them would cost as much."""
SETTLED_ROUNDS = 4
"""Number of solutions of each hypothesis before a comparison, if there are more than `at_once`."""
AHEAD = 0.5
"""Standard deviation of a heated plate's lead over its reading, as a fraction of the lead."""
LOOK_AGAIN_S = (0.15, 0.4, 1.0, 2.5)
"""Times after contact when the readings are summed again, s; each time the linearisation is nearer to the touch."""
AGAIN_AT_ONCE = BLOCK
"""Number of earlier readings summed again in one turn."""
MOST_AGAIN = 300
"""Maximum number of hypotheses for which readings are summed again; with more, some must be dropped first."""
STRAYED_SD = 2.5
"""Distance from its range beyond which a substance for a range of effusivities is ignored, standard deviations.

The neighbouring substance is nearer and more exact there.
"""
LARGEST_STEP = 0.3
"""Largest change of a logarithm from one solution to the next."""
Intervals = tuple[tuple[float, float], ...]
SOLVE_EVERY_S: Intervals = ((0.5, 0.02), (1.0, 0.04), (math.inf, 0.10))
"""Ends of periods, s after contact, and the interval between two solutions in each, s.

Hypotheses change most at first. Solutions come at multiples of the interval, so that one comes at each time in the
tables (1 s, 2 s, ...).
"""
_ORDER = np.array([1, 2, 4, 5, 0, 3])
"""Order of the six parameters in the equations; the parameters of the evidence come last."""


@dataclass(frozen=True, slots=True)
class TouchEvidence:
    """Evidence of one touch on each substance: (m,) and, for (temperature, ln effusivity), (m, 2) and (m, 2, 2).

    Attributes:
        ln_likelihood: ln likelihood of the readings; FORGET below the best hypothesis if all hypotheses of the
            substance were dropped or have strayed.
        mean: mean of the object's temperature relative to ambient, K, and of ln effusivity.
        covariance: covariance of both.
        ambient_c: ambient temperature, C.
        start_c: temperature of the plate at contact, C.
        misfit: mean square of the best hypothesis's residuals over the noise's variance; 1 for a perfect fit.
        common_k2: variance of an error of the temperature that all touches share, K2; not part of `covariance`.
    """

    ln_likelihood: Array
    mean: Array
    covariance: Array
    ambient_c: float
    start_c: float
    misfit: float
    common_k2: Array | float = 0.0


def solve_interval_s(since_s: float, solve_every_s: Intervals = SOLVE_EVERY_S) -> float:
    """Return the time from one solution to the next, s, at `since_s` seconds after contact."""
    return next(every_s for until_s, every_s in solve_every_s if since_s < until_s - NEARLY_S)


def last_solution_s(lasts_s: float, solve_every_s: Intervals = SOLVE_EVERY_S) -> float:
    """Return the time of the last solution of a touch whose readings are used up to `lasts_s`, s."""
    every_s = solve_interval_s(lasts_s, solve_every_s)
    return every_s * math.floor((lasts_s + NEARLY_S) / every_s)


class TouchEstimate:
    """The running estimate of one touch: `take` each reading, 100 a second, and `work` after it."""

    def __init__(
        self,
        table: MaterialTable,
        substances: Substances,
        guesses: TouchHypotheses,
        start_c: float,
        slope_k_s: float,
        ambient_c: float,
        back_k: tuple[float, float] = (0.0, 0.0),
        at_once: int | None = None,
        solve_every_s: Intervals = SOLVE_EVERY_S,
    ) -> None:
        """Begin at contact.

        Args:
            table: calibrated sensor and materials.
            substances: substances of `table`.
            guesses: hypotheses of `table`; fingers share them.
            start_c: reading at contact, C.
            slope_k_s: slope of the reading just before contact, K/s.
            ambient_c: ambient temperature, C.
            back_k: difference of the back's temperature from calibration, and its standard deviation, K.
            at_once: number of hypotheses solved with one reading; more than this and FEW take turns. None means all.
            solve_every_s: intervals between solutions, as SOLVE_EVERY_S; the last period ends at infinity.
        """
        self._solve_every_s = solve_every_s
        count = len(guesses.substance)
        self._settled_rounds = 1 if at_once is None or count <= at_once else SETTLED_ROUNDS
        self._at_once = count if at_once is None or count <= FEW else at_once
        self._substances = substances
        self._ambient_c, self._start_c = ambient_c, start_c
        self._noise_k = table.noise_k
        sensor = SensorConstants(table.leak_per_s, table.half_force_n, table.early_s, table.force_power)
        self._sensor = sensor
        self._sums = NormalEquations(sensor, guesses.contacts, guesses.contact_of, guesses.ln_lag, table.noise_k)
        self._slope_k_s = slope_k_s
        self._slab_s = guesses.contacts.slab_s[guesses.contact_of]
        self._readings: list[Reading] = []
        self._again: NormalEquations | None = None
        self._looks = list(LOOK_AGAIN_S)
        n = len(guesses.substance)
        ambient_k = ambient_c - start_c
        self._expected = np.zeros((6, n))
        self._expected[0] = ambient_k
        self._expected[1] = slope_k_s * np.exp(guesses.ln_lag)
        self._expected[2] = (1.0 - table.back_share) * ambient_k + back_k[0]
        variances = np.empty((3, n))
        variances[0] = ANYWHERE_K**2
        variances[1] = table.start_sd_k**2 + (AHEAD * self._expected[1]) ** 2
        variances[2] = table.back_sd_k**2 + back_k[1] ** 2
        self._precision = np.zeros((6, 6, n))
        self._precision[(0, 1, 2), (0, 1, 2)] = 1.0 / variances
        self._precision[3:, 3:] = np.moveaxis(guesses.precision, 0, 2)
        self._ln_prior = guesses.ln_weight + 0.5 * (guesses.ln_determinant - np.log(variances).sum(axis=0))
        self._mean, self._covariance = self._expected.copy(), np.zeros((2, 2, n))
        """Means of the six parameters, and covariance of the object's temperature and ln effusivity."""
        self._ln_weight = guesses.ln_weight.copy()
        self._misfit = np.zeros(n)
        self._substance = guesses.substance
        self._group()
        self._far_below = np.zeros(n, dtype=np.intp)
        """Number of consecutive comparisons in which each hypothesis was far below the best."""
        self._used = 0
        """Number of readings in the last solution."""
        self._evidence: TouchEvidence | None = None
        self._next = self._rounds = 0
        self._solve_from_s = 0.0
        """Time of the next solution, s after contact."""
        self.news = False
        """Whether the last work completed a solution of all hypotheses."""
        self.solved = True
        """Whether all hypotheses have been solved from the same readings; many of them take a few turns."""
        self._since_s = 0.0
        self._pressed = ContactChange(sensor)

    def take(self, dt_s: float, reading_c: float, force_n: float) -> None:
        """Take one reading, for later work; `force_n` is the mean since the previous reading, `dt_s` before."""
        self._since_s += dt_s
        changed = self._pressed.step(dt_s, force_n)
        self._readings.append(Reading(dt_s, reading_c - self._start_c, force_n, changed))

    @property
    def waited_s(self) -> float:
        """Time since a solution, or a new sum of earlier readings, became due, s; negative if none is due."""
        return max(self._solution_waited_s, self._look_waited_s)

    @property
    def _solution_waited_s(self) -> float:
        return self._since_s - (self._solve_from_s - NEARLY_S)

    @property
    def _look_waited_s(self) -> float:
        if not self._looks or self._mean.shape[1] > MOST_AGAIN:
            return NOTHING_DUE
        return self._since_s - (self._looks[0] - NEARLY_S)

    def work(self) -> None:
        """Do one turn of the due work: a new sum that waited too long, else a solution, else a new sum."""
        self.news = False
        overdue_s = POSTPONED_S if self._look_waited_s >= POSTPONED_S else 0.0
        if self._solution_waited_s >= overdue_s:
            self._solve_some()
            self.news = self.solved
            if self.news:
                every_s = solve_interval_s(self._since_s, self._solve_every_s)
                self._solve_from_s = every_s * (math.floor((self._since_s + NEARLY_S) / every_s) + 1)
        elif self._look_waited_s >= 0.0:
            self._look_again()

    def _loosen_plate(self, contact_variance: float) -> None:
        """Widen the prior of the plate at contact by the effect of the earlier contact on its temperature."""
        carried = self._sums.carried_variance(contact_variance * self._difference_k**2)
        grown = 1.0 + carried * self._precision[PLATE, PLATE]
        self._precision[PLATE, PLATE] /= grown
        self._ln_prior -= 0.5 * np.log(grown)

    @property
    def _difference_k(self) -> Array:
        """Difference between plate and object at contact for each hypothesis, K."""
        return np.asarray(self._mean[1] - self._mean[0])

    def _look_again(self) -> None:
        """Sum some readings again around the present parameters of each hypothesis."""
        if self._again is None:
            ln_effusivity, ln_conductance, ln_lag = self._sums.around + self._mean[3:]
            contacts = Contacts(ln_effusivity, ln_conductance, self._slab_s)
            self._again = NormalEquations(self._sensor, contacts, np.arange(len(ln_lag)), ln_lag, self._noise_k)
        done = self._again.count
        self._again.take(self._readings[done : min(done + AGAIN_AT_ONCE, self._sums.count)], self._difference_k)
        if self._again.count == self._sums.count:
            moved = self._again.around - self._sums.around
            self._expected[3:] -= moved
            self._expected[1] = self._slope_k_s * np.exp(self._again.around[2])
            self._mean[3:] -= moved
            self._sums, self._again = self._again, None
            self._looks.pop(0)
            self._next = 0

    @property
    def settled(self) -> bool:
        """Whether the hypotheses can be compared."""
        return self._rounds >= self._settled_rounds

    def settle(self) -> None:
        """Use all readings, without a limit of time."""
        self._take_readings()
        while self._again is not None:
            self._look_again()
        self._next = 0
        self._solve_some()
        while not self.solved:
            self._solve_some()

    def _take_readings(self) -> None:
        """Sum the readings since the last solution."""
        readings, sums = self._readings, self._sums
        for number in range(sums.count, len(readings)):
            if (changed := readings[number].contact_variance) > 0.0:
                sums.take(readings[sums.count : number], self._difference_k)
                self._loosen_plate(changed)
        sums.take(readings[sums.count :], self._difference_k)

    def _solve_some(self) -> None:
        """Solve the next hypotheses from the readings that the first one had; after the last one, compare them."""
        if self._next == 0:
            self._take_readings()
            sums = self._sums
            self._solved_from = sums.information.copy(), sums.vector.copy(), sums.square.copy()
            self._used = len(self._readings)
            self._unlikely = np.empty_like(self._ln_weight)
        part = slice(self._next, self._next + self._at_once)
        self._solve(part)
        self._next = part.stop
        self.solved = self._next >= len(self._ln_weight)
        if self.solved:
            self._next = 0
            self._rounds += 1
            self._evidence = None
            self._ln_weight = self._ln_prior + self._sums.ln_blurred - 0.5 * self._unlikely
            self._prune()

    def _solve(self, part: slice) -> None:
        """Take one Gauss-Newton step of some hypotheses, and compute their weights there."""
        information, vector, square = (sums[..., part] for sums in self._solved_from)
        precision, expected = self._precision[..., part], self._expected[:, part]
        mean = self._mean[:, part]
        system = np.empty((6, 7, mean.shape[1]))
        system[:, :6] = information
        system[:, 6] = vector - _times(information, _seen(mean))
        _by_numbers(system, mean)
        _by_numbers(system.swapaxes(0, 1), mean)
        system[:, :6] += precision
        system[:, 6] += _times(precision, expected - mean)
        solution, ln_determinant, self._covariance[..., part] = _solved(system[_ORDER[:, None], (*_ORDER, 6)])
        solution[_ORDER] = solution.copy()
        solution[3:] = np.minimum(np.maximum(solution[3:], -LARGEST_STEP), LARGEST_STEP)
        mean += solution
        seen, off = _seen(mean), mean - expected
        self._misfit[part] = square + _along(seen, _times(information, seen) - 2.0 * vector)
        self._unlikely[part] = self._misfit[part] + _along(off, _times(precision, off)) + ln_determinant

    def _prune(self) -> None:
        self._far_below = np.where(self._ln_weight > self._ln_weight.max() - FORGET, 0, self._far_below + 1)
        likely = self._far_below < PATIENCE
        if np.count_nonzero(likely) > 0.9 * len(likely):
            return
        self._sums.keep(likely)
        if self._again is not None:
            self._again.keep(likely)
        self._mean, self._covariance = self._mean[:, likely], self._covariance[..., likely]
        self._expected, self._precision = self._expected[:, likely], self._precision[..., likely]
        self._misfit, self._far_below = self._misfit[likely], self._far_below[likely]
        self._ln_weight, self._ln_prior = self._ln_weight[likely], self._ln_prior[likely]
        self._substance, self._slab_s = self._substance[likely], self._slab_s[likely]
        self._group()

    def _group(self) -> None:
        """Find the substances that are left, the first hypothesis of each, and the group of each hypothesis."""
        self._groups = np.unique(self._substance, return_index=True, return_inverse=True)

    def evidence(self) -> TouchEvidence:
        """Return the evidence of all solved readings, with the hypotheses of each substance drawn together."""
        if self._evidence is None:
            self._evidence = self._drawn_together()
        return self._evidence

    def _drawn_together(self) -> TouchEvidence:
        known = self._substances
        left, first, of = self._groups  # hypotheses are in the order of their substances
        top = np.maximum.reduceat(self._ln_weight, first)
        weight = np.exp(self._ln_weight - top[of])
        total = np.add.reduceat(weight, first)
        weight /= total[of]
        numbers = np.stack((self._mean[0] + (self._start_c - self._ambient_c), self._sums.around[0] + self._mean[3]))
        mean = np.add.reduceat(weight * numbers, first, axis=1)
        away = numbers - mean[:, of]
        covariance = np.add.reduceat(weight * (self._covariance + away[:, None] * away), first, axis=2)
        least = self._ln_weight.max() - FORGET
        usual, variance = known.ln_effusivity[left], known.effusivity_variance[left]
        strayed = np.abs(mean[1] - usual) > STRAYED_SD * np.sqrt(variance)
        counts = (top >= least) & ((left < known.calibrated) | ~strayed)
        # A dropped substance is as likely as when it was dropped, and as uncertain as its prior. Fingers that dropped
        # different substances can then be judged together. Without both, they could agree on what each rules out.
        kept = left[counts]
        ln_likelihood = np.full(len(known.probability), least)
        ln_likelihood[kept] = (top + np.log(total))[counts]
        means = np.stack((np.zeros_like(ln_likelihood), known.ln_effusivity), axis=1)
        means[kept] = mean.T[counts]
        covariances = np.zeros((*means.shape, 2))
        covariances[:, 0, 0], covariances[:, 1, 1] = ANYWHERE_K**2, known.effusivity_variance
        covariances[kept] = covariance.transpose(2, 0, 1)[counts]
        return TouchEvidence(
            ln_likelihood - self._used * math.log(self._noise_k),
            means,
            covariances,
            self._ambient_c,
            self._start_c,
            float(self._misfit[np.argmax(self._ln_weight)]) / max(self._used, 1),
        )


def _seen(mean: Array) -> Array:
    """Return the factors of the courses: three temperatures, and three offsets times the difference."""
    seen = mean.copy()
    seen[3:] *= mean[1] - mean[0]
    return seen


def _by_numbers(rows: Array, mean: Array) -> None:
    """Convert derivatives by `_seen`, (6, any, n), to derivatives by the six parameters, in place."""
    moved = np.einsum("kjn,kn->jn", rows[3:6], mean[3:])
    rows[0] -= moved
    rows[1] += moved
    rows[3:6] *= mean[1] - mean[0]


def _solved(system: Array) -> tuple[Array, Array, Array]:
    """Solve positive definite equations by elimination in place.

    Args:
        system: (6, 7, n) equations, with the right side last.

    Returns:
        The solution (6, n), ln of the determinant (n,), and the last two rows of the inverse, (2, 2, n).
    """
    size = len(system)
    for k in range(size - 1):
        if k == size - 2:
            (one, both), (_, other) = system[k:, k:size].copy()
        rest = system[k, k + 1 :] / system[k, k]
        system[k + 1 :, k + 1 :] -= system[k + 1 :, k, None] * rest
        system[k, k + 1 :] = rest
    covariance = np.array([[other, -both], [-both, one]]) / (one * other - both * both)
    solution = system[:, size]
    ln_determinant = np.log(np.diagonal(system[:, :size])).sum(axis=1)
    solution[-1] /= system[-1, size - 1]
    for k in range(size - 1, 0, -1):
        solution[:k] -= system[:k, k] * solution[k]
    return solution, ln_determinant, covariance


def _times(matrix: Array, vector: Array) -> Array:
    """Multiply matrix and vector of every hypothesis, (i, j, n) and (j, n)."""
    return np.asarray(np.einsum("ijn,jn->in", matrix, vector))


def _along(one: Array, other: Array) -> Array:
    """Return the scalar product for every hypothesis, (i, n) each."""
    return np.asarray(np.einsum("in,in->n", one, other))
