"""Independent reference of a finger on a half space: 320 uneven cells, banded Crank-Nicolson, small steps.

Constants are copied again from their sources. Only the materials' constants come from the program.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

LAYERS = (
    (0.45e-3, 0.24, 1200.0, 3590.0, 0.0),
    (1.2e-3, 0.45, 1200.0, 3300.0, 0.005),
    (5e-3, 0.19, 1000.0, 2500.0, 0.00125),
)
"""Thickness, m, conductivity, W/(m K), density, kg/m3, specific heat, J/(kg K), and perfusion, 1/s, of epidermis,
dermis, subcutis."""
COUNTS = (80, 60, 60)
OBJECT_CELLS = 120
BLOOD = 1060.0 * 3770.0
STEPS_S = ((0.0005, 400), (0.002, 900), (0.01, 800))
"""Lengths of steps, s, and the number of steps of each; 10 s in all."""
DEEP_C = 34.0
LOW_C, HIGH_C = 10.0, 50.0
"""Temperatures of the two simulated objects, C; others are interpolated."""


@dataclass(frozen=True)
class FeltCourse:
    """Felt temperature over time, C, for an object at LOW_C and at HIGH_C."""

    time_s: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def at(self, object_c: float) -> np.ndarray:
        """Felt temperature for an object at `object_c`, C."""
        share = (object_c - LOW_C) / (HIGH_C - LOW_C)
        return np.asarray(self.low + share * (self.high - self.low))


def felt_course(conductivity: float, heat_j_m3k: float, contact: float, air_c: float = 25.0) -> FeltCourse:
    """Course of a finger at rest in air, then in contact for 10 s."""
    size, k, heat, perfused = _tissue()
    half = size / (2.0 * k)
    links = 1.0 / (half[:-1] + half[1:])
    blood = perfused * BLOOD * size
    to_deep = 1.0 / half[-1]
    # at rest
    to_air = 1.0 / (0.1 + half[0])
    matrix = _tridiagonal(links, blood)
    matrix[1, 0] += to_air
    matrix[1, -1] += to_deep
    known = blood * (DEEP_C + 1.0)
    known[0] += to_air * air_c
    known[-1] += to_deep * DEEP_C
    rest = solve_banded((1, 1), matrix, known)
    # in contact: object from far to near, then tissue
    depth = 12.0 * np.sqrt(conductivity / heat_j_m3k * 10.0)
    object_size = depth * 1.07 ** np.arange(OBJECT_CELLS, 0, -1.0)
    object_size *= depth / object_size.sum()
    object_half = object_size / (2.0 * conductivity)
    joined = np.concatenate((object_half, half))
    all_links = 1.0 / (joined[:-1] + joined[1:])
    all_links[OBJECT_CELLS - 1] = 1.0 / (object_half[-1] + contact + half[0])
    capacity = np.concatenate((object_size * heat_j_m3k, heat))
    loss = np.concatenate((np.zeros(OBJECT_CELLS), blood))
    balance = _tridiagonal(all_links, loss)
    balance[1, -1] += to_deep
    source = loss * (DEEP_C + 1.0)
    source[-1] += to_deep * DEEP_C
    felt_cells = slice(OBJECT_CELLS, OBJECT_CELLS + COUNTS[0])
    state = np.stack([np.concatenate((np.full(OBJECT_CELLS, object_c), rest)) for object_c in (LOW_C, HIGH_C)], axis=1)
    time_s, felt, t_s = [0.0], [state[felt_cells].mean(axis=0)], 0.0
    for step_s, count in STEPS_S:
        explicit = -0.5 * step_s * balance
        explicit[1] += capacity
        implicit = 0.5 * step_s * balance
        implicit[1] += capacity
        first = step_s * balance / 4.0
        first[1] += capacity
        for number in range(count):
            if t_s == 0.0 and number == 0:  # Rannacher start: four short implicit steps damp a sudden contact
                for _ in range(4):
                    state = solve_banded((1, 1), first, capacity[:, None] * state + (step_s / 4.0) * source[:, None])
            else:
                state = solve_banded((1, 1), implicit, _product(explicit, state) + step_s * source[:, None])
            t_s += step_s
            time_s.append(t_s)
            felt.append(state[felt_cells].mean(axis=0))
    courses = np.array(felt)
    return FeltCourse(np.array(time_s), courses[:, 0], courses[:, 1])


def _tissue() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    size, k, heat, perfused = [], [], [], []
    for (thickness, conductivity, density, specific, perfusion), count in zip(LAYERS, COUNTS, strict=True):
        size.append(np.full(count, thickness / count))
        k.append(np.full(count, conductivity))
        heat.append(np.full(count, thickness / count * density * specific))
        perfused.append(np.full(count, perfusion))
    return np.concatenate(size), np.concatenate(k), np.concatenate(heat), np.concatenate(perfused)


def _tridiagonal(links: np.ndarray, loss: np.ndarray) -> np.ndarray:
    banded = np.zeros((3, len(loss)))
    banded[0, 1:] = banded[2, :-1] = -links
    banded[1] = loss
    banded[1, :-1] += links
    banded[1, 1:] += links
    return banded


def _product(banded: np.ndarray, columns: np.ndarray) -> np.ndarray:
    result = banded[1][:, None] * columns
    result[:-1] += banded[0, 1:, None] * columns[1:]
    result[1:] += banded[2, :-1, None] * columns[:-1]
    return np.asarray(result)
