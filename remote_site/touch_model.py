"""The plate of a thermal sensor on an object, for many guesses about the object at once.

With the heater off the plate (per area: C'' dT/dt = -h (T - T_surface) - g (T - T_back)) loses heat through the contact
into the object and leaks into the Peltier's back; its resistor reads it late. Only ratios to the plate's heat capacity
show in the readings, so every constant is one: contact conductance h/C'' in 1/s, leak g/C'' in 1/s, effusivity e/C'' in
1/sqrt(s). The response is linear in the temperatures of object, plate and back: three courses that add up to one.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from remote_site.conduction import DECAYS_PER_S, mode_weights

Array = NDArray[np.float64]

PLATE_J_M2K = 1980.0
"""Nominal heat capacity of the plate per area: turns the model's ratios into effusivity and conductance for people."""
COURSES = 6
"""Columns of `TouchModel.courses`."""
_STEP = 0.02
"""Change of a logarithm by which the slopes of a course are taken."""
_GRID_S = 2e-6
"""Lengths of steps are rounded to this, s."""
_MOST_LENGTHS = 16
"""Largest number of lengths whose factors are kept. A late site gets readings 10, 20 or 30 ms apart."""
_PLATES = 4
"""Of each contact: plate warm; the same with more effusivity; with more conductance; only the back warm."""


@dataclass(frozen=True, slots=True)
class SensorConstants:
    """What all touches of one kind of sensor have in common.

    Attributes:
        leak_per_s: conductance from the plate into the Peltier's back and the case, 1/s.
        half_force_n: force at which the contact conducts half as well as at large force, N.
        force_power: a light contact conducts like this power of the force: about 1 for hard pads, more for soft ones.
        early_s: heat flows so long before the force tells of contact, s; negative where it flows later.
    """

    leak_per_s: float
    half_force_n: float
    early_s: float = 0.0
    force_power: float = 1.0

    def force_share(self, force_n: Array | float) -> Array:
        """Part of the full contact conductance at a force, 0..1."""
        pressing = (np.maximum(force_n, 0.0) / self.half_force_n) ** self.force_power
        return np.asarray(pressing / (1.0 + pressing))


@dataclass(frozen=True, slots=True)
class Contacts:
    """Guesses about object and contact, (p,) each.

    Attributes:
        ln_effusivity: of the object, in 1/sqrt(s).
        ln_conductance: of the contact at large force, in 1/s.
        slab_s: thickness^2 / diffusivity of the object, s; infinite for a half space.
    """

    ln_effusivity: Array
    ln_conductance: Array
    slab_s: Array


class _Factors(NamedTuple):
    """Factors of one length of step: of the modes' heat, of the surface's temperature, and of the readings."""

    dt_s: float
    decay: Array
    fill: Array
    warms: Array
    slow: Array
    quick: Array


class TouchModel:
    """Courses of n guesses: each one of p contacts, read with one lag.

    Attributes:
        courses: (n, 6), the reading relative to that at contact, per kelvin of object, plate at contact and back;
            then the slopes of the reading by the logarithms of effusivity, conductance and lag, per kelvin between
            plate and object.
    """

    def __init__(
        self, sensor: SensorConstants, contacts: Contacts, contact_of: NDArray[np.intp], ln_lag: Array
    ) -> None:
        """Begin at contact.

        Args:
            sensor: constants of the sensor.
            contacts: p contacts.
            contact_of: (n,) which of them each guess has.
            ln_lag: (n,) of the read-out, in s.
        """
        self._sensor = sensor
        effusivity, conductance = np.exp(contacts.ln_effusivity), np.exp(contacts.ln_conductance)
        more = np.exp(_STEP)
        self._conductance = np.stack((conductance, conductance, conductance * more, conductance))
        weights = np.stack([mode_weights(float(slab_s)) for slab_s in contacts.slab_s])
        resistance = 1.0 / np.stack((effusivity, effusivity * more, effusivity, effusivity))
        self._weights: Array = weights.T[:, None, :] * resistance
        self._heat = np.zeros_like(self._weights)
        self._plate = np.ones_like(resistance)
        self._plate[3] = 0.0
        self._back = np.array([0.0, 0.0, 0.0, 1.0])[:, None]
        self._surface = np.zeros_like(resistance)
        self._contact_of = contact_of
        lag_s = np.exp(ln_lag)
        self._lag_s = np.stack((lag_s, lag_s, lag_s, lag_s, lag_s * more))
        self._read = np.zeros_like(self._lag_s)
        self._start = np.ones((2, len(lag_s)))
        """What is left in the resistor of its own temperature at contact."""
        self._lengths: dict[int, _Factors] = {}
        self._early_s = sensor.early_s
        self.courses = np.zeros((len(lag_s), COURSES))

    def keep(self, which: NDArray[np.bool_]) -> None:
        """Go on with some of the guesses only."""
        used, self._contact_of = np.unique(self._contact_of[which], return_inverse=True)
        self._conductance, self._weights = self._conductance[:, used], self._weights[..., used]
        self._heat, self._plate, self._surface = self._heat[..., used], self._plate[:, used], self._surface[:, used]
        self._lag_s, self._read, self._start = self._lag_s[:, which], self._read[:, which], self._start[:, which]
        self.courses = self.courses[which]
        self._lengths.clear()

    def step(self, dt_s: float, force_n: Array | float) -> None:
        """Advance by `dt_s` (s) at a force (N), one for all contacts or (p,)."""
        if self._early_s > 0.0:
            self._advance(self._early_s, force_n)
            self._early_s = 0.0
        elif self._early_s < 0.0:
            waits_s = min(-self._early_s, dt_s)
            self._early_s += waits_s
            self._advance(waits_s, 0.0)
            dt_s -= waits_s
        if dt_s > 0.0:
            self._advance(dt_s, force_n)

    def _advance(self, dt_s: float, force_n: Array | float) -> None:
        length = round(dt_s / _GRID_S)
        if (factors := self._lengths.get(length)) is None:
            factors = self._factors(length * _GRID_S)
            if len(self._lengths) >= _MOST_LENGTHS:
                self._lengths.clear()
            self._lengths[length] = factors
        before = self._plate
        self._conduct(factors, self._conductance * self._sensor.force_share(force_n))
        twice = (before + self._plate)[:, self._contact_of]
        self._read *= factors.slow
        self._read[:_PLATES] += twice * factors.quick[:_PLATES]
        self._read[_PLATES] += twice[0] * factors.quick[_PLATES]
        self._start *= factors.slow[3:]
        plate, by_effusivity, by_conductance, back, by_lag = self._read
        start, start_by_lag = self._start
        self.courses[:, 0] = 1.0 - plate - back - start
        self.courses[:, 1] = plate
        self.courses[:, 2] = back
        self.courses[:, 3] = (by_effusivity - plate) / _STEP
        self.courses[:, 4] = (by_conductance - plate) / _STEP
        self.courses[:, 5] = (by_lag + start_by_lag - plate - start) / _STEP

    def _conduct(self, factors: _Factors, conductance: Array) -> None:
        """Move heat from plate to object with the flux that is steady over a step: second order in its length."""
        leak, dt_s = self._sensor.leak_per_s, factors.dt_s
        heat = self._heat * factors.decay
        surface = np.einsum("mcp,mcp->cp", self._weights, heat)
        pull = dt_s / (2.0 + leak * dt_s)
        coasting = self._plate - pull * leak * (self._plate - self._back)
        flux = conductance * (coasting - 0.5 * (self._surface + surface))
        flux /= 1.0 + conductance * (pull + 0.5 * factors.warms)
        self._plate = 2.0 * (coasting - pull * flux) - self._plate
        self._heat = heat + factors.fill * flux
        self._surface = surface + factors.warms * flux

    def _factors(self, dt_s: float) -> _Factors:
        slow_per_s = np.maximum(DECAYS_PER_S, 1e-9)
        fill = -np.expm1(-slow_per_s * dt_s) / slow_per_s
        ratio = dt_s / (2.0 * self._lag_s)
        return _Factors(
            dt_s,
            decay=np.exp(-DECAYS_PER_S * dt_s)[:, None, None],
            fill=fill[:, None, None],
            warms=np.einsum("mcp,m->cp", self._weights, fill),
            slow=(1.0 - ratio) / (1.0 + ratio),
            quick=ratio / (1.0 + ratio),
        )
