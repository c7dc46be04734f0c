"""Simulate heat in the thermal sensors of n remote fingers and in the objects that they touch.

A sensor has a plate, the back side of its Peltier element, a case, and a silicon resistor with a lag. Below the plate
is the touched object, a column of finite volumes behind a contact conductance that depends on force. The system is
linear and solved implicitly in two stages a step (SDIRK2). This method has second order and is L-stable: a step of any
size is stable, and a sudden contact does not ring. Constants and spreads: docs/decisions/0002-simulated-world.md.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_sensors.physics.object_column import CELLS, ObjectColumn
from sim_sensors.physics.ssr_converter import NOISE_C, counts_of
from sim_sensors.physics.thermistor_contacts import ThermistorContacts

Array = NDArray[np.float64]

STEP_S = 0.010
STAGE_SHARE = 1.0 - math.sqrt(0.5)
STAGE_S = STAGE_SHARE * STEP_S
"""Length of an implicit stage, s; object columns are prepared for it."""
_SECOND = (1.0 - STAGE_SHARE) / STAGE_SHARE

AREA_M2 = 14e-3 * 14e-3
PLATE_LENGTH_M = 14e-3
PLATE_J_K = 0.388
BACK_J_K = 3.0
CASE_J_K = 1.3
PELTIER_W_K = 8e-3
CASE_LEAK_W_K = 4e-3
BACK_AMBIENT_W_K = 25e-3
CASE_AMBIENT_W_K = 10e-3
AIR_W_M2K = 10.0
HEATER_W = 2.0
_SIDES_J_K = np.array([[BACK_J_K], [CASE_J_K]])
_SIDES_W_K = _SIDES_J_K / STAGE_S
_SIDES_AMBIENT_W_K = np.array([[BACK_AMBIENT_W_K], [CASE_AMBIENT_W_K]])
"""Conductances of back side and case to the surroundings, W/K."""
BACK_HEATING = -0.5
"""Heat into the Peltier's back side per heat into the plate, when heating: electric power less the plate's heat."""
BACK_COOLING = 1.5
"""Heat into the Peltier's back side per heat out of the plate, when cooling: the plate's heat plus electric power."""

GAP_AIR_W_MK = 0.026
GAP_M = 14.4e-6
GAP_PER_RMS = 2.0
SPOT_W_M2K = 400.0
HALF_FORCE_N = 0.3
FORCE_EXPONENT = 0.6
TOUCH_SPREAD = 0.15
LEAK_SPREAD = 0.10
LAG_S = (0.2, 0.5)


@dataclass(frozen=True, slots=True)
class SensorSpread:
    """Spread between n sensors: lag of the resistor, s, and leaks of Peltier and case as multiples of nominal."""

    lag_s: Array
    leak: Array

    @classmethod
    def draw(cls, count: int, rng: np.random.Generator) -> "SensorSpread":
        """Draw `count` sensors."""
        return cls(rng.uniform(*LAG_S, count), np.exp(LEAK_SPREAD * rng.standard_normal(count)))


def full_conductance_w_m2k(conductivity_w_mk: float, rms_m: float) -> float:
    """Return the contact conductance of plate and object at large force, before the spread of a touch, W/m2K.

    Two paths are in parallel: air in the gap, which the object's roughness widens, and contact spots, which constrict
    the flow.
    """
    gap = GAP_AIR_W_MK / (GAP_M + GAP_PER_RMS * rms_m)
    return gap + SPOT_W_M2K * conductivity_w_mk / (conductivity_w_mk + 1.0)


def force_share(force_n: Array) -> Array:
    """Return the share of the full contact conductance at a force, 0..1, by a saturating power law."""
    ratio = (np.maximum(force_n, 0.0) / HALF_FORCE_N) ** FORCE_EXPONENT
    return ratio / (1.0 + ratio)


def draw_touch_factor(rng: np.random.Generator, spread: float = TOUCH_SPREAD) -> float:
    """Draw the contact conductance of one touch as a multiple of nominal (lognormal)."""
    return math.exp(spread * rng.standard_normal())


class ThermalTouch:
    """Temperatures of n sensors, C, initially at ambient, and `contacts` of their resistors with the plates.

    `plate_c`, `back_c`, `case_c`, `ssr_c` have shape (n,); `column_c` (n, cells) holds the touched objects.
    """

    def __init__(self, spread: SensorSpread, ambient_c: float, rng: np.random.Generator, cells: int = CELLS) -> None:
        self._n = n = spread.lag_s.size
        self._rng = rng
        self.ambient_c = ambient_c
        self.plate_c = np.full(n, ambient_c)
        self._sides_c = np.full((2, n), ambient_c)
        self.ssr_c = np.full(n, ambient_c)
        self.contacts = ThermistorContacts(n)
        self.column_c = np.full((n, cells), ambient_c)
        self.object_c = np.full(n, ambient_c)
        self.area_m2 = np.full(n, AREA_M2)
        self._leak_w_k = np.stack((PELTIER_W_K * spread.leak, CASE_LEAK_W_K * spread.leak))
        """Conductances from the plate to back side and case, W/K."""
        self._lag_gain = STAGE_S / spread.lag_s
        self._inverse = np.zeros((n, cells, cells))
        self._response = np.zeros((n, cells))
        self._half_cell = np.ones(n)
        self._full = np.zeros(n)
        self._touching = np.zeros(n, dtype=bool)
        self._touches: set[int] = set()
        self._columns: list[ObjectColumn | None] = [None] * n
        self._sides_known_w = _SIDES_AMBIENT_W_K * ambient_c
        """Ambient term of the heat flow into back side and case, W."""
        self._sides_sum = _SIDES_J_K / STAGE_S + self._leak_w_k + _SIDES_AMBIENT_W_K
        back_w_k, case_w_k = self._leak_w_k * (1.0 - self._leak_w_k / self._sides_sum)
        self._plate_sum = PLATE_J_K / STAGE_S + back_w_k + case_w_k
        self._convert()

    @property
    def back_c(self) -> Array:
        """Temperature of each Peltier element's back side, C."""
        back: Array = self._sides_c[0]
        return back

    @property
    def case_c(self) -> Array:
        """Temperature of each case, C."""
        case: Array = self._sides_c[1]
        return case

    def touch(
        self, finger: int, column: ObjectColumn, object_c: float, conductance_w_m2k: float, area_share: float = 1.0
    ) -> None:
        """Put `column` below a finger at contact or on sliding to another object; keep the column's temperatures.

        `conductance_w_m2k` is the conductance of this touch at large force (see `full_conductance_w_m2k`). `object_c`
        is the temperature of material not touched yet.
        """
        self._full[finger] = conductance_w_m2k
        self.object_c[finger] = object_c
        self.area_m2[finger] = AREA_M2 * area_share
        self._touching[finger] = True
        self._touches.add(finger)
        if self._columns[finger] is not column:
            self._columns[finger] = column
            self._inverse[finger] = column.inverse
            self._response[finger] = column.response
            self._half_cell[finger] = column.half_cell_m2k_w

    def settle(self, finger: int) -> None:
        """Set all of a finger's column to the object's temperature, as at a new contact."""
        self.column_c[finger] = self.object_c[finger]

    def release(self, finger: int) -> None:
        """Remove the object from a finger."""
        self._touching[finger] = False
        self._touches.discard(finger)
        self._full[finger] = 0.0

    def step(self, drive: Array, force_n: Array, speed_m_s: float = 0.0) -> None:
        """Advance by STEP_S.

        Args:
            drive: Peltier drive (n,), -1..1.
            force_n: contact force (n,), N.
            speed_m_s: sliding speed; fresh material replaces the column as the plate moves over it.
        """
        if speed_m_s > 0.0:
            fresh = -math.expm1(-speed_m_s * STEP_S / PLATE_LENGTH_M)
            self.column_c += fresh * (self.object_c[:, None] - self.column_c)
        if self._touches:
            contact = self._full * force_share(force_n)
            conductance = contact / (1.0 + contact * self._half_cell)
            conductance /= 1.0 + conductance * self._response[:, 0]
        else:
            conductance = np.zeros(self._n)
        into_object = conductance * self.area_m2
        heat = HEATER_W * np.minimum(np.maximum(drive, -1.0), 1.0)
        back_heat = np.where(heat > 0.0, BACK_HEATING, -BACK_COOLING) * heat
        air = np.where(self._touching, 0.0, AIR_W_M2K * AREA_M2)
        heats, plate_sum = (heat, back_heat, air * self.ambient_c), self._plate_sum + into_object + air
        column, plate, sides, ssr = start = self.column_c, self.plate_c, self._sides_c, self.ssr_c
        new_column, new_plate, new_sides, new_ssr = self._stage(start, conductance, into_object, heats, plate_sum)
        second = (
            column + _SECOND * (new_column - column),
            plate + _SECOND * (new_plate - plate),
            sides + _SECOND * (new_sides - sides),
            ssr + _SECOND * (new_ssr - ssr),
        )
        self.column_c, self.plate_c, self._sides_c, self.ssr_c = self._stage(
            second, conductance, into_object, heats, plate_sum
        )
        self._convert()

    def ssr_counts(self) -> NDArray[np.int16]:
        """Return the latest reading of each plate's resistor, counts; each step makes a reading with new noise."""
        return self._ssr_counts

    def ambient_counts(self) -> NDArray[np.int16]:
        """Return the latest reading of each ambient sensor, counts."""
        return self._ambient_counts

    def _stage(
        self,
        rest: tuple[Array, Array, Array, Array],
        conductance: Array,
        into_object: Array,
        heats: tuple[Array, Array, Array],
        plate_sum: Array,
    ) -> tuple[Array, Array, Array, Array]:
        """Solve one implicit stage from `rest`: eliminate column, back side and case, and solve for the plate.

        `heats` are the heat flows into the plate, into the back side, and from the air into the plate, W.
        """
        column, plate, sides, ssr = rest
        heat, back_heat, air_w = heats
        carried = np.matmul(self._inverse, column[:, :, None])[:, :, 0]
        surface = carried[:, 0]
        known = _SIDES_W_K * sides
        known[0] += back_heat
        known += self._sides_known_w
        from_back, from_case = self._leak_w_k * (known / self._sides_sum)
        new_plate = (
            (PLATE_J_K / STAGE_S) * plate + heat + into_object * surface + air_w + from_back + from_case
        ) / plate_sum
        flux = conductance * (new_plate - surface)
        return (
            carried + self._response * flux[:, None],
            new_plate,
            (known + self._leak_w_k * new_plate) / self._sides_sum,
            (ssr + self._lag_gain * new_plate) / (1.0 + self._lag_gain),
        )

    def _convert(self) -> None:
        read_c = NOISE_C * self._rng.standard_normal((2, self._n))
        read_c[0] += self.contacts.read(STEP_S, self.ssr_c, self.ambient_c)
        read_c[1] += self.ambient_c
        counts = counts_of(read_c)
        self._ssr_counts: NDArray[np.int16] = counts[0]
        self._ambient_counts: NDArray[np.int16] = counts[1]
