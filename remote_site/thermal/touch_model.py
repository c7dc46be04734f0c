"""Models the plate of a thermal sensor on an object, for many hypotheses about the object at once.

With the heater off, the plate (per area: C'' dT/dt = -h (T - T_surface) - g (T - T_back)) loses heat through the
contact into the object and leaks into the Peltier's back. Its resistor reads it with a lag. The readings show only
ratios to the plate's heat capacity, so that every constant is such a ratio: contact conductance h/C'' in 1/s, leak
g/C'' in 1/s, effusivity e/C'' in 1/sqrt(s). The response is linear in the temperatures of object, plate and back: it is
the sum of three courses, whose factors add up to one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.conduction import DECAYS_PER_S, mode_weights

Array = NDArray[np.float64]

PLATE_J_M2K = 1980.0
"""Nominal heat capacity of the plate per area, J/(m2 K); it converts the model's ratios for display."""
COURSES = 6
"""Number of columns of `TouchModel.courses`."""
BLOCK = 12
"""Maximum number of readings in one block."""
_STEP = 0.02
"""Change of a logarithm from which the slopes of a course are computed."""
_GRID_S = 2e-6
"""Grid to which lengths of steps are rounded, s."""
_MOST_LENGTHS = 16
"""Maximum number of lengths whose factors are kept. A late site gets readings 10, 20 or 30 ms apart."""
_PLATES = 4
"""Number of plates of each contact: warm plate; with more effusivity; with more conductance; only a warm back."""
_BACK = np.array([0.0, 0.0, 0.0, 1.0])[:, None]
"""Temperature of the back of each plate."""
_OF_READ: Array = np.array(
    [
        [-1.0, 0.0, 0.0, -1.0, 0.0, -1.0, 0.0],
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        [-1.0 / _STEP, 1.0 / _STEP, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-1.0 / _STEP, 0.0, 1.0 / _STEP, 0.0, 0.0, 0.0, 0.0],
        [-1.0 / _STEP, 0.0, 0.0, 0.0, 1.0 / _STEP, -1.0 / _STEP, 1.0 / _STEP],
    ]
)
"""Matrix from readings to courses; the course of the object also needs the constant 1.

Columns are the readings of each plate, of the first plate with more lag, and the remains of the resistor's temperature
at contact, with the lag and with more lag.
"""


@dataclass(frozen=True, slots=True)
class SensorConstants:
    """Constants of all touches of one kind of sensor.

    Attributes:
        leak_per_s: conductance from the plate into the Peltier's back and the case, 1/s.
        half_force_n: force at which the contact conducts half as well as at large force, N.
        force_power: exponent of the force in a light contact's conductance: about 1 for hard pads, more for soft ones.
        early_s: time by which heat flows before the force shows contact, s; negative if it flows later.
    """

    leak_per_s: float
    half_force_n: float
    early_s: float = 0.0
    force_power: float = 1.0

    def force_share(self, force_n: Array | float) -> Array:
        """Return the share of the full contact conductance at a force, 0..1."""
        pressing = (np.maximum(force_n, 0.0) / self.half_force_n) ** self.force_power
        return np.asarray(pressing / (1.0 + pressing))


@dataclass(frozen=True, slots=True)
class Contacts:
    """Hypotheses about object and contact, (p,) each.

    Attributes:
        ln_effusivity: ln effusivity of the object, effusivity in 1/sqrt(s).
        ln_conductance: ln conductance of the contact at large force, conductance in 1/s.
        slab_s: thickness^2 / diffusivity of the object, s; infinite for a half space.
    """

    ln_effusivity: Array
    ln_conductance: Array
    slab_s: Array


class _Factors(NamedTuple):
    """Factors for one length of step.

    Attributes:
        decays: (BLOCK + 1, modes) decay of the modes after each number of steps.
        fill: (modes, 4, p) temperature of the surface by each mode per flux.
        keeps: (BLOCK + 1, 1, 1) share of a plate's difference from its back that is left after each number of steps.
        drains: (BLOCK + 1, BLOCK) loss of the plate due to each step's flux, after each number of steps.
        coast: twice the share of that difference that is left in the middle of a step.
        gives: (4, p) approach of plate and surface within a step, per flux.
        later: (BLOCK - 1, 4, p) approach of plate and surface after each number of later steps, per flux.
        slow: (7, n) share of the previous reading in the next one.
        quick: (5, n) share of the plate before, and of the plate after a step, in the next reading.
    """

    decays: Array
    fill: Array
    keeps: Array
    drains: Array
    coast: float
    gives: Array
    later: Array
    slow: Array
    quick: Array


class TouchModel:
    """Courses of n hypotheses, each with one of p contacts and one lag.

    Attributes:
        courses: (n, 6) newest reading relative to that at contact, per kelvin of object, plate at contact and back.
            The last three columns are slopes of the reading by the logarithms of effusivity, conductance and lag, per
            kelvin between plate and object.
    """

    def __init__(
        self, sensor: SensorConstants, contacts: Contacts, contact_of: NDArray[np.intp], ln_lag: Array
    ) -> None:
        """Begin at contact.

        Args:
            sensor: constants of the sensor.
            contacts: p contacts.
            contact_of: (n,) index of each hypothesis's contact.
            ln_lag: (n,) ln(lag of the read-out in s).
        """
        self._sensor = sensor
        effusivity, conductance = np.exp(contacts.ln_effusivity), np.exp(contacts.ln_conductance)
        more = np.exp(_STEP)
        self._conductance = np.stack((conductance, conductance, conductance * more, conductance))
        weights = np.stack([mode_weights(float(slab_s)) for slab_s in contacts.slab_s], axis=1)
        self._weights: Array = weights[:, None, :] / np.stack((effusivity, effusivity * more, effusivity, effusivity))
        self._modes = np.zeros_like(self._weights)
        """Contribution of each mode to the surface's temperature."""
        self._plate = np.ones_like(self._conductance) - 2.0 * _BACK
        """Temperature of each plate relative to its back, so that the leak is a simple decay."""
        self._contact_of = contact_of
        lag_s = np.exp(ln_lag)
        self._lag_s = np.stack((lag_s, lag_s, lag_s, lag_s, lag_s * more, lag_s, lag_s * more))
        self._read = np.zeros_like(self._lag_s)
        self._read[_PLATES + 1 :] = 1.0
        """Readings of the plates, of the first with more lag, and the remains of the resistor's initial temperature."""
        self._lengths: dict[int, _Factors] = {}
        self._early_s = sensor.early_s
        self.courses = np.zeros((len(lag_s), COURSES))

    def keep(self, which: NDArray[np.bool_]) -> None:
        """Keep only some of the hypotheses."""
        used, self._contact_of = np.unique(self._contact_of[which], return_inverse=True)
        self._conductance, self._weights = self._conductance[:, used], self._weights[..., used]
        self._modes, self._plate = self._modes[..., used], self._plate[:, used]
        self._lag_s, self._read = self._lag_s[:, which], self._read[:, which]
        self.courses = self.courses[which]
        self._lengths.clear()

    def advance(self, dt_s: Sequence[float], force_n: Array) -> Array:
        """Advance by k readings; steps of equal length form one block.

        Args:
            dt_s: length of each step, s.
            force_n: (k,) force in each step, N; or (k, p) for each contact.

        Returns:
            The courses after each step, (k, 6, n).
        """
        found = np.empty((len(dt_s), COURSES, len(self._contact_of)))
        first = 0
        while first < len(dt_s):
            after = first + 1
            if self._early_s:
                found[first] = self._begin(dt_s[first], force_n[first:after])
            else:
                length = round(dt_s[first] / _GRID_S)
                most = min(first + BLOCK, len(dt_s))
                while after < most and round(dt_s[after] / _GRID_S) == length:
                    after += 1
                found[first:after] = self._advance(length, force_n[first:after])
            first = after
        self.courses = found[-1].T
        return found

    def _begin(self, dt_s: float, force_n: Array) -> Array:
        """Advance through the step in which heat begins to flow, before or after the force shows contact."""
        if self._early_s > 0.0:
            courses = self._advance(round(self._early_s / _GRID_S), force_n)
            self._early_s = 0.0
        else:
            waits_s = min(-self._early_s, dt_s)
            self._early_s += waits_s
            courses = self._advance(round(waits_s / _GRID_S), np.zeros(1))
            dt_s -= waits_s
        if dt_s > 0.0:
            courses = self._advance(round(dt_s / _GRID_S), force_n)
        return np.asarray(courses[-1])

    def _advance(self, length: int, force_n: Array) -> Array:
        """Advance by a block of steps of one length; return the courses after each step."""
        if (factors := self._lengths.get(length)) is None:
            factors = self._factors(length * _GRID_S)
            if len(self._lengths) >= _MOST_LENGTHS:
                self._lengths.clear()
            self._lengths[length] = factors
        twice = self._conduct(factors, self._sensor.force_share(force_n))[..., self._contact_of]
        read = np.zeros((len(force_n), *self._read.shape))
        np.multiply(twice, factors.quick[:_PLATES], out=read[:, :_PLATES])
        np.multiply(twice[:, 0], factors.quick[_PLATES], out=read[:, _PLATES])
        before = self._read
        for k in range(len(read)):
            read[k] += factors.slow * before
            before = read[k]
        self._read = before
        courses = _OF_READ @ read
        courses[:, 0] += 1.0
        return np.asarray(courses)

    def _conduct(self, factors: _Factors, share: Array) -> Array:
        """Move heat from plate to object with a constant flux in each step; the method is of second order.

        It first computes twice the difference in the middle of each step without any flux in this block. Then each
        step's flux lowers the difference in the later steps.

        Args:
            factors: factors of the steps.
            share: (k,) or (k, p) share of the full conductance in each step.

        Returns:
            Sum of each plate's temperature before and after each step, (k, 4, p).
        """
        steps, shape = len(share), self._plate.shape
        conductance = self._conductance * share.reshape(steps, 1, -1)
        gain = 0.5 * conductance / (1.0 + conductance * factors.gives)
        surface = (factors.decays[: steps + 1] @ self._modes.reshape(len(self._modes), -1)).reshape(-1, *shape)
        plate = factors.keeps[: steps + 1] * self._plate
        difference = factors.coast * plate[:-1] + 2.0 * _BACK - surface[:-1] - surface[1:]
        flux = np.empty_like(difference)
        for k in range(steps):
            np.multiply(difference[k], gain[k], out=flux[k])
            difference[k + 1 :] -= factors.later[: steps - k - 1] * flux[k]
        flat = flux.reshape(steps, -1)
        self._modes *= factors.decays[steps][:, None, None]
        self._modes += factors.fill * (factors.decays[:steps][::-1].T @ flat).reshape(self._modes.shape)
        plate -= (factors.drains[: steps + 1, :steps] @ flat).reshape(plate.shape)
        self._plate = plate[-1]
        return np.asarray(plate[:-1] + plate[1:] + 2.0 * _BACK)

    def _factors(self, dt_s: float) -> _Factors:
        slow_per_s = np.maximum(DECAYS_PER_S, 1e-9)
        decays = np.exp(-DECAYS_PER_S * dt_s * np.arange(BLOCK + 1)[:, None])
        fill = self._weights * (-np.expm1(-slow_per_s * dt_s) / slow_per_s)[:, None, None]
        warms = (decays[:BLOCK] @ fill.reshape(len(fill), -1)).reshape(BLOCK, *self._plate.shape)
        pull = dt_s / (2.0 + self._sensor.leak_per_s * dt_s)
        leaked = pull * self._sensor.leak_per_s
        coast, keep = 2.0 * (1.0 - leaked), 1.0 - 2.0 * leaked
        since = np.arange(BLOCK + 1)[:, None] - np.arange(1, BLOCK + 1)
        drains = np.where(since < 0, 0.0, 2.0 * pull * keep ** np.maximum(since, 0))
        ratio = dt_s / (2.0 * self._lag_s)
        return _Factors(
            decays=decays,
            fill=fill,
            keeps=np.power(keep, np.arange(BLOCK + 1.0))[:, None, None],
            drains=drains,
            coast=coast,
            gives=pull + 0.5 * warms[0],
            later=coast * drains[1:BLOCK, 0, None, None] + warms[:-1] + warms[1:],
            slow=(1.0 - ratio) / (1.0 + ratio),
            quick=(ratio / (1.0 + ratio))[: _PLATES + 1],
        )
