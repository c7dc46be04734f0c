"""Thermal model of a TactTip and of the fingertip that rests on it.

Four Peltier elements in series heat or cool an aluminium plate (10 x 15 x 0.5 mm); their other side sits on a
water-cooled block. The finger is a column of 40 cells: epidermis, dermis and subcutis. Perfusion and the warm
inside of the finger supply it with heat. It always rests on the plate, through a contact resistance.

Heat pumped into the plate at the current I:  S I T_plate + I^2 R/2 + K (T_hot - T_plate). The Joule term is
positive for both signs of the current, so heating is faster than cooling. A warmer hot side weakens the cooling.

Conduction is linear, so one matrix replaces five implicit (backward Euler) steps of 2 ms and advances 10 ms. Blocks
with cooling water have one matrix, blocks without have another.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim_sensors.physics.thermistor_contacts import ThermistorContacts

STEP_S = 0.010
IMPLICIT_STEPS = 5
_ROUNDING_S = 1e-9
"""Rounding error of a sum of steps, s."""

PLATE_AREA_M2 = 0.010 * 0.015
PLATE_CAPACITY_J_K = 0.30
"""Heat capacity of the plate, J/K: aluminium 0.18, share of the Peltiers' ceramic, solder and the NTC 0.12."""
PLATE_FINGER_M2K_W = 5.4e-4

PELTIER_CURRENT_A = 1.0
"""Full current of the four Peltier elements in series, A."""
PELTIER_SEEBECK_V_K = 3.95e-3
"""Seebeck coefficient of the four Peltier elements in series, V/K."""
PELTIER_OHM = 0.78
"""Resistance of the four Peltier elements in series, ohm."""
PELTIER_W_K = 0.008
"""Thermal conductance of the four Peltier elements together, W/K."""

HOT_SIDE_CAPACITY_J_K = 6.0
HOT_SIDE_K_W = 0.8
WATER_C = 20.0
DRY_HOT_SIDE_K_W = 50.0
"""Thermal resistance from hot side to room without water, K/W: 20 cm2 of block and module in still air, 10 W/m2K."""
ROOM_C = 23.0
AIR_W_M2K = 10.0
CASE_W_K = 0.002
"""Thermal conductance from the plate to the room through the case, W/K."""

NTC_LAG_S = 0.06
NTC_NOISE_K = 0.01

DEEP_C = 34.0
ARTERY_C = 35.0
BLOOD_J_M3K = 1060.0 * 3770.0
LAYERS = (
    # thickness m, cells, growth from cell to cell, conductivity W/mK, heat capacity J/m3K, perfusion 1/s
    (0.48e-3, 12, 1.08, 0.22, 1200.0 * 3600.0, 0.0),
    (1.15e-3, 14, 1.06, 0.40, 1200.0 * 3600.0, 0.005),
    (5.5e-3, 14, 1.15, 0.20, 1000.0 * 2500.0, 0.00125),
)
EPIDERMIS_CELLS = LAYERS[0][1]
KELVIN = 273.15

_PLATE = 0
_SKIN = 1  # first of the finger's cells


def finger_column() -> tuple[NDArray[np.float64], ...]:
    """Return thickness, conductivity, heat capacity per volume and perfusion of each cell, outermost first."""
    thickness, conductivity, capacity, perfusion = [], [], [], []
    for depth_m, cells, growth, k, volumetric, flow in LAYERS:
        widths = growth ** np.arange(cells)
        thickness.append(depth_m * widths / widths.sum())
        conductivity.append(np.full(cells, k))
        capacity.append(np.full(cells, volumetric))
        perfusion.append(np.full(cells, flow))
    return tuple(np.concatenate(part) for part in (thickness, conductivity, capacity, perfusion))


class _Conduction(NamedTuple):
    """Linear map of all node temperatures over 10 ms of conduction with constant pumped heat.

    Attributes:
        advance: matrix from the temperatures before to those after, (nodes, nodes).
        offset: rise caused by the surroundings, K, (nodes, 1).
        pumped: rise per heat flow pumped into plate and hot side, K/W, (nodes, 2).
    """

    advance: NDArray[np.float64]
    offset: NDArray[np.float64]
    pumped: NDArray[np.float64]

    @classmethod
    def of(
        cls, flow: NDArray[np.float64], source: NDArray[np.float64], heat_capacity: NDArray[np.float64]
    ) -> "_Conduction":
        """Build the map from conductances between nodes, W/K, heat from outside, W, and heat capacities, J/K."""
        implicit = np.linalg.inv(np.eye(len(source)) - flow / heat_capacity[:, None] * (STEP_S / IMPLICIT_STEPS))
        summed = sum(np.linalg.matrix_power(implicit, n) for n in range(1, IMPLICIT_STEPS + 1))
        respond = np.asarray(summed) * (STEP_S / IMPLICIT_STEPS) / heat_capacity
        advance = np.linalg.matrix_power(implicit, IMPLICIT_STEPS)
        return cls(advance, (respond @ source)[:, None], respond[:, [_PLATE, -1]])

    def __call__(self, state: NDArray[np.float64], pumped_w: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the temperatures (nodes, fingers) after 10 ms, with heat (2, fingers), W, into plate and hot side."""
        after: NDArray[np.float64] = self.advance @ state + self.offset + self.pumped @ pumped_w
        return after


class FingerPlates:
    """Plates, Peltiers and fingertips of `count` TactTips.

    Attributes:
        plate_c, hot_side_c, surface_c, felt_c: temperatures of the plate, of the water-cooled side, of the
            skin's surface and of its epidermis (mean over depth, which the person senses), C, one per finger.
        ntc_c: temperature of the plate's NTC element, C, with lag and noise.
        dry: fingers whose hot side has lost its cooling water, bool; False at first.
        reversed: fingers whose Peltiers are wired in reverse, so that a drive above 0 cools, bool; False at first.
        contacts: thermal contacts of the NTCs, one per finger.
    """

    def __init__(self, count: int, seed: int, ntc_noise_k: float = NTC_NOISE_K) -> None:
        """Start with fingers from free air, just put on the plates; `ntc_noise_k` is the SD of each NTC's noise, K."""
        thickness, conductivity, capacity, perfusion = finger_column()
        cells = len(thickness)
        size = cells + 2
        hot = size - 1
        half = thickness / (2.0 * conductivity)
        between = PLATE_AREA_M2 / (half[:-1] + half[1:])
        self._skin_w_k = PLATE_AREA_M2 / (PLATE_FINGER_M2K_W + half[0])
        self._surface_k_per_k = PLATE_FINGER_M2K_W * self._skin_w_k / PLATE_AREA_M2
        self._epidermis = thickness[:EPIDERMIS_CELLS] / thickness[:EPIDERMIS_CELLS].sum()

        heat_capacity = np.empty(size)
        heat_capacity[_PLATE] = PLATE_CAPACITY_J_K
        heat_capacity[_SKIN:hot] = PLATE_AREA_M2 * thickness * capacity
        heat_capacity[hot] = HOT_SIDE_CAPACITY_J_K
        flow = np.zeros((size, size))  # W/K between nodes
        links = [(_PLATE, _SKIN, self._skin_w_k), (_PLATE, hot, PELTIER_W_K)]
        links += [(_SKIN + i, _SKIN + i + 1, float(g)) for i, g in enumerate(between)]
        for a, b, conductance in links:
            flow[a, b] += conductance
            flow[b, a] += conductance
            flow[a, a] -= conductance
            flow[b, b] -= conductance
        source = np.zeros(size)  # W from the surroundings, at their constant temperatures
        blood = PLATE_AREA_M2 * thickness * perfusion * BLOOD_J_M3K
        deep = PLATE_AREA_M2 / half[-1]
        for node, conductance, around_c in (
            *((_SKIN + i, float(g), ARTERY_C) for i, g in enumerate(blood)),
            (hot - 1, float(deep), DEEP_C),
            (hot, 1.0 / HOT_SIDE_K_W, WATER_C),
            (_PLATE, CASE_W_K, ROOM_C),
        ):
            flow[node, node] -= conductance
            source[node] += conductance * around_c
        self._watered = _Conduction.of(flow, source, heat_capacity)
        flow[hot, hot] += 1.0 / HOT_SIDE_K_W - 1.0 / DRY_HOT_SIDE_K_W
        source[hot] = ROOM_C / DRY_HOT_SIDE_K_W
        self._dry = _Conduction.of(flow, source, heat_capacity)
        skin = self._finger_in_air(flow[_SKIN:hot, _SKIN:hot], source[_SKIN:hot], float(half[0]))
        start = np.concatenate(([skin[0]], skin, [WATER_C]))
        self._state = np.repeat(start[:, None], count, axis=1)
        self.dry: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        self.reversed: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        self.contacts = ThermistorContacts(count)
        self._random = np.random.default_rng([seed, 0x9A7E])
        self._noise_k = ntc_noise_k
        self._since_s = 0.0
        self._charge = [0.0] * count
        self._ntc = self.plate_c.copy()
        self.ntc_c: NDArray[np.float64] = self._ntc.copy()

    def _finger_in_air(
        self, flow: NDArray[np.float64], source: NDArray[np.float64], half_cell_m2k_w: float
    ) -> NDArray[np.float64]:
        """Return the steady temperatures of a finger in free air, C."""
        to_air = PLATE_AREA_M2 / (1.0 / AIR_W_M2K + half_cell_m2k_w)
        free_flow, free_source = flow.copy(), source.copy()
        free_flow[0, 0] += self._skin_w_k - to_air
        free_source[0] += to_air * ROOM_C
        steady: NDArray[np.float64] = np.linalg.solve(free_flow, -free_source).astype(np.float64)
        return steady

    @property
    def plate_c(self) -> NDArray[np.float64]:
        """Temperature of each plate, C."""
        plate: NDArray[np.float64] = self._state[_PLATE]
        return plate

    @property
    def hot_side_c(self) -> NDArray[np.float64]:
        """Temperature of each water-cooled block, C."""
        hot_side: NDArray[np.float64] = self._state[-1]
        return hot_side

    @property
    def surface_c(self) -> NDArray[np.float64]:
        """Temperature of the skin's surface on each plate, C."""
        plate = self._state[_PLATE]
        surface: NDArray[np.float64] = plate - (plate - self._state[_SKIN]) * self._surface_k_per_k
        return surface

    @property
    def felt_c(self) -> NDArray[np.float64]:
        """Mean temperature of each epidermis, C, where the person senses warmth and cold."""
        felt: NDArray[np.float64] = self._epidermis @ self._state[_SKIN : _SKIN + EPIDERMIS_CELLS]
        return felt

    def step(self, dt_s: float, drive: NDArray[np.float64]) -> None:
        """Advance by `dt_s` with a signed `drive` (-1..1 of the full current, above 0 heats) on each Peltier.

        Heat advances in steps of 10 ms, with the mean drive of each step; `dt_s` is at most as long.
        """
        self._since_s += dt_s
        self._charge = [charge + part * dt_s for charge, part in zip(self._charge, drive.tolist(), strict=True)]
        if self._since_s < STEP_S - _ROUNDING_S:
            return
        over_s = self._since_s - STEP_S
        over_s = over_s if over_s > _ROUNDING_S else 0.0
        over = drive * over_s
        sign = np.where(self.reversed, -PELTIER_CURRENT_A, PELTIER_CURRENT_A)
        current = (np.array(self._charge) - over) * sign / (self._since_s - over_s)
        self._since_s, self._charge = over_s, over.tolist()
        joule = current * current * (PELTIER_OHM / 2.0)
        seebeck = current * PELTIER_SEEBECK_V_K
        pumped = np.array(
            (
                joule + seebeck * (self._state[_PLATE] + KELVIN),
                joule - seebeck * (self._state[-1] + KELVIN),
            )
        )
        before, self._state = self._state, self._watered(self._state, pumped)
        if self.dry.any():
            self._state = np.where(self.dry, self._dry(before, pumped), self._state)
        self._ntc += (self._state[_PLATE] - self._ntc) * (STEP_S / (NTC_LAG_S + STEP_S))
        reads_c = self.contacts.read(STEP_S, self._ntc, ROOM_C)
        self.ntc_c = reads_c + self._noise_k * self._random.standard_normal(len(current))
