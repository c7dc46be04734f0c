"""Sums the readings of a touch as normal equations for many hypotheses, linearised around each hypothesis.

A reading is linear in three temperatures, and near a hypothesis in three logarithms (effusivity, conductance, lag).
Sums over the readings therefore hold all of their information, independent of the present estimate. Far from its
parameters, a hypothesis is limited by its slopes. The readings can then be summed again around better parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.touch_model import COURSES, Contacts, SensorConstants, TouchModel

Array = NDArray[np.float64]

PLATE, CONDUCTANCE = 1, 4
"""Indices of two courses: that of the plate at contact, and the slope by the contact's conductance."""
COOLED = 0.05
"""Lower limit of the remaining share of the plate's initial temperature where it is a divisor, 0..1."""


@dataclass(slots=True)
class Reading:
    """One reading of a plate in contact.

    Attributes:
        dt_s: time since the previous reading, s.
        above_start_k: reading relative to that at contact, K.
        force_n: mean force since the previous reading, N.
        contact_variance: variance of a change of the contact's ln conductance just before, beyond the law.
    """

    dt_s: float
    above_start_k: float
    force_n: float
    contact_variance: float


class NormalEquations:
    """Sums over readings for n hypotheses.

    Attributes:
        around: (3, n) ln effusivity, ln conductance and ln lag at which the slopes were taken.
        information: (6, 6, n) sums over products of two courses, in units of the noise.
        vector: (6, n) sums over courses times readings.
        square: (n,) sums over squared readings.
        ln_blurred: (n,) loss of ln probability due to changes of contact.
        count: number of readings taken.
    """

    def __init__(
        self, sensor: SensorConstants, contacts: Contacts, contact_of: NDArray[np.intp], ln_lag: Array, noise_k: float
    ):
        """Begin at contact; `noise_k` is the standard deviation of a reading's noise, K. See `TouchModel`."""
        self._model = TouchModel(sensor, contacts, contact_of, ln_lag)
        self._per_noise = 1.0 / noise_k
        n = len(ln_lag)
        self.around = np.stack((contacts.ln_effusivity[contact_of], contacts.ln_conductance[contact_of], ln_lag))
        self.information, self.vector = np.zeros((COURSES, COURSES, n)), np.zeros((COURSES, n))
        self.square, self.ln_blurred = np.zeros(n), np.zeros(n)
        self.count = 0

    def take(self, readings: Sequence[Reading], difference_k: Array) -> None:
        """Take more readings; a changed contact needs `difference_k` (n,) between plate and object at contact, K."""
        first = 0
        for after in range(1, len(readings) + 1):
            if after == len(readings) or readings[after].contact_variance > 0.0:
                self._take(readings[first:after], difference_k)
                first = after

    def _take(self, readings: Sequence[Reading], difference_k: Array) -> None:
        """Take readings of one contact, which may have changed just before the first."""
        if readings[0].contact_variance > 0.0:
            variance = readings[0].contact_variance * difference_k**2
            self._blur(CONDUCTANCE, variance)
            self._blur(PLATE, self.carried_variance(variance))
        above = np.array([reading.above_start_k for reading in readings]) * self._per_noise
        force_n = np.array([reading.force_n for reading in readings])
        courses = self._model.advance([reading.dt_s for reading in readings], force_n)
        courses *= self._per_noise
        self.information += np.einsum("kin,kjn->ijn", courses, courses)
        self.vector += np.einsum("k,kin->in", above, courses)
        self.square += above @ above
        self.count += len(readings)

    def carried_variance(self, variance: Array) -> Array:
        """Return a variance of the plate at contact, K^2, with the effect of a changed contact on later readings.

        `variance` (n,) is that of the contact's ln conductance times the square of plate minus object, K^2.
        """
        plate, by_conductance = self._model.courses[:, PLATE], self._model.courses[:, CONDUCTANCE]
        return np.asarray(variance * (by_conductance / np.maximum(plate, COOLED)) ** 2)

    def _blur(self, column: int, variance: Array) -> None:
        """Allow the factor of one course in earlier readings to differ from the present one by this variance."""
        row, at = self.information[column].copy(), self.vector[column].copy()
        share = variance / (1.0 + variance * row[column])
        self.information -= share * row[:, None] * row
        self.vector -= share * at * row
        self.square -= share * at * at
        self.ln_blurred -= 0.5 * np.log1p(variance * row[column])

    def keep(self, which: NDArray[np.bool_]) -> None:
        """Keep only some of the hypotheses."""
        self._model.keep(which)
        self.around = self.around[:, which]
        self.information, self.vector = self.information[..., which], self.vector[:, which]
        self.square, self.ln_blurred = self.square[which], self.ln_blurred[which]
