"""What the readings of a touch say about guesses, to first order around each guess's numbers.

A reading is linear in three temperatures, and near a guess in three logarithms (effusivity, conductance, lag). Sums
over the readings therefore hold all that they say, whatever is believed meanwhile. Away from its numbers a guess is
only as good as its slopes: the readings can be summed again around better numbers.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.touch_model import COURSES, Contacts, SensorConstants, TouchModel

Array = NDArray[np.float64]

PLATE, CONDUCTANCE = 1, 4
"""Rows of the courses: by the plate at contact, and the slopes by the contact's conductance."""
COOLED = 0.05
"""A plate that has less than this of its warmth left carries nothing on, as a share."""


@dataclass(slots=True)
class Reading:
    """One reading of a plate in contact.

    Attributes:
        dt_s: since the one before, s.
        above_start_k: reading relative to that at contact, K.
        force_n: mean force since the one before, N.
        variance: of its noise, K^2.
        contact_variance: by how much the contact's ln conductance has changed just before, beyond the law.
    """

    dt_s: float
    above_start_k: float
    force_n: float
    variance: float
    contact_variance: float


class NormalEquations:
    """Sums over readings for n guesses.

    Attributes:
        around: (3, n) ln effusivity, ln conductance and ln lag that the slopes were taken at.
        information: (6, 6, n) over pairs of courses, in units of the noise.
        vector: (6, n) over courses times reading.
        square: (n,) over readings squared.
        ln_blurred: (n,) what contacts that changed cost a guess in ln probability.
        count: readings taken.
    """

    def __init__(self, sensor: SensorConstants, contacts: Contacts, contact_of: NDArray[np.intp], ln_lag: Array):
        """Begin at contact; see `TouchModel`."""
        self._model = TouchModel(sensor, contacts, contact_of, ln_lag)
        n = len(ln_lag)
        self.around = np.stack((contacts.ln_effusivity[contact_of], contacts.ln_conductance[contact_of], ln_lag))
        self.information, self.vector = np.zeros((COURSES, COURSES, n)), np.zeros((COURSES, n))
        self.square, self.ln_blurred = np.zeros(n), np.zeros(n)
        self.count = 0

    def take(self, readings: Sequence[Reading], difference_k: Array) -> None:
        """More readings; `difference_k` (n,) between plate and object at contact is used where a contact changed."""
        first = 0
        for after in range(1, len(readings) + 1):
            if after == len(readings) or readings[after].contact_variance > 0.0:
                self._take(readings[first:after], difference_k)
                first = after

    def _take(self, readings: Sequence[Reading], difference_k: Array) -> None:
        """Readings of one contact, which may have changed just before the first."""
        if readings[0].contact_variance > 0.0:
            variance = readings[0].contact_variance * difference_k**2
            self._blur(CONDUCTANCE, variance)
            self._blur(PLATE, self.carried_variance(variance))
        weight = np.array([reading.variance for reading in readings]) ** -0.5
        above = np.array([reading.above_start_k for reading in readings]) * weight
        force_n = np.array([reading.force_n for reading in readings])
        courses = self._model.advance([reading.dt_s for reading in readings], force_n)
        courses *= weight[:, None, None]
        self.information += np.einsum("kin,kjn->ijn", courses, courses)
        self.vector += np.einsum("k,kin->in", above, courses)
        self.square += above @ above
        self.count += len(readings)

    def carried_variance(self, variance: Array) -> Array:
        """Of the plate at contact, K^2, that does to later readings what a contact did that was so different until now.

        Args:
            variance: (n,) of the contact's ln conductance times the difference between plate and object, K^2.
        """
        plate, by_conductance = self._model.courses[:, PLATE], self._model.courses[:, CONDUCTANCE]
        return np.asarray(variance * (by_conductance / np.maximum(plate, COOLED)) ** 2)

    def _blur(self, column: int, variance: Array) -> None:
        """Readings so far were of a contact, or a plate, whose factor differs from now by this variance."""
        row, at = self.information[column].copy(), self.vector[column].copy()
        share = variance / (1.0 + variance * row[column])
        self.information -= share * row[:, None] * row
        self.vector -= share * at * row
        self.square -= share * at * at
        self.ln_blurred -= 0.5 * np.log1p(variance * row[column])

    def keep(self, which: NDArray[np.bool_]) -> None:
        """Go on with some of the guesses only."""
        self._model.keep(which)
        self.around = self.around[:, which]
        self.information, self.vector = self.information[..., which], self.vector[:, which]
        self.square, self.ln_blurred = self.square[which], self.ln_blurred[which]
