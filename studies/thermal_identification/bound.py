"""Theoretical information limit: the Cramer-Rao bound with priors (van Trees) for a known material.

The bound compares the sensitivity of a noise-free simulated touch to each drawn parameter with the noise of a reading.
It limits how well the object's temperature can be estimated. It holds for estimates near the truth and does not bound
the share of right names. Uniform draws count as normal ones with the same standard deviation.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.scenes.materials import material
from sim_sensors.physics.object_column import object_column
from sim_sensors.physics.ssr_converter import FULL_COUNTS, HIGH_OHM, LINEAR_PER_K, LOW_OHM, NOISE_C, R25_OHM
from sim_sensors.physics.thermal_touch import (
    LAG_S,
    LEAK_SPREAD,
    STAGE_S,
    STEP_S,
    TOUCH_SPREAD,
    SensorSpread,
    ThermalTouch,
    full_conductance_w_m2k,
)
from sim_sensors.traces.simulated_touch import BLOCK_M, PREHEAT_PER_K, REACH_S_K, WARM_S
from studies.thermal_identification.situations import AMBIENT_C

Array = NDArray[np.float64]

ROUGHNESS_M = 1e-6
"""Roughness of the touched surface, m; that of a plain surface."""
PRESSED_S = 0.1
FORCE_N = 1.2
SHARED = 2
"""Number of shared parameters: the object's temperature and ln effusivity come first; the others are each finger's."""
_STEPS = np.array((0.05, 0.01, 0.01, 0.02, 0.02, 0.2))
"""Steps of the numerical derivatives: object, K, ln effusivity, ln conductance, ln lag, ln leak, and warm-up, s."""


def reading_noise_k() -> float:
    """Return the standard deviation of one reading from the sensor's noise and its converter's resolution, K."""
    step_k = (HIGH_OHM - LOW_OHM) / FULL_COUNTS / (R25_OHM * LINEAR_PER_K)
    return float(np.hypot(NOISE_C, step_k / np.sqrt(12.0)))


def prior_sd(spread: float) -> Array:
    """Return the prior standard deviation of each parameter; `spread` is that of ln effusivity."""
    wide_lag = (LAG_S[1] - LAG_S[0]) / np.sqrt(12.0) / np.mean(LAG_S)
    warm_s = (WARM_S[1] - WARM_S[0]) / np.sqrt(12.0)
    return np.array((6.0 / np.sqrt(12.0), spread, TOUCH_SPREAD, wide_lag, LEAK_SPREAD, warm_s))


def slopes(name: str, preheat_k: float, seconds: float) -> Array:
    """Return the derivative of each reading after contact by each parameter, around a usual touch, (readings, 6)."""
    count = len(_STEPS)
    shift = np.concatenate((np.diag(_STEPS), -np.diag(_STEPS)))  # (12, 6): up, then down
    kind = material(name)
    lag_s = np.mean(LAG_S) * np.exp(shift[:, 3])
    thermal = ThermalTouch(SensorSpread(lag_s, np.exp(shift[:, 4])), AMBIENT_C, np.random.default_rng(0))
    warm_s = REACH_S_K * preheat_k + float(np.mean(WARM_S)) + 1.0 + shift[:, 5]
    longest_s, idle = float(warm_s.max()), np.zeros(2 * count)
    for step in range(round(longest_s / STEP_S)):
        heating = PREHEAT_PER_K * (AMBIENT_C + preheat_k - thermal.plate_c)
        thermal.step(np.where(longest_s - step * STEP_S <= warm_s, heating, 0.0), idle)
    heat_j_m3k = kind.density_kg_m3 * kind.specific_heat_j_kgk
    full = full_conductance_w_m2k(kind.conductivity_w_mk, ROUGHNESS_M)
    for one in range(2 * count):
        scale = float(np.exp(shift[one, 1]))
        column = object_column(kind.conductivity_w_mk * scale, heat_j_m3k * scale, BLOCK_M, STAGE_S)
        thermal.touch(one, column, AMBIENT_C + shift[one, 0], full * float(np.exp(shift[one, 2])))
        thermal.settle(one)
    readings = np.empty((round(seconds / STEP_S), 2 * count))
    for step, reading in enumerate(readings):
        thermal.step(idle, np.full(2 * count, FORCE_N * min((step + 1) * STEP_S / PRESSED_S, 1.0)))
        reading[:] = thermal.ssr_c
    return np.asarray((readings[:, :count] - readings[:, count:]) / (2.0 * _STEPS))


def bounds(name: str, preheats_k: Sequence[float], times_s: Sequence[float]) -> list[dict[str, Any]]:
    """Return least standard deviations, a row for each time and number of fingers, in the order of `preheats_k`."""
    by_preheat = {preheat_k: slopes(name, preheat_k, times_s[-1]) for preheat_k in set(preheats_k)}
    prior = prior_sd(material(name).spread)
    rows = []
    for t_s in times_s:
        seen = {preheat_k: each[: round(t_s / STEP_S)] for preheat_k, each in by_preheat.items()}
        for fingers in range(1, len(preheats_k) + 1):
            used = [seen[preheat_k] for preheat_k in preheats_k[:fingers]]
            rows.append(
                {
                    "material": name,
                    "fingers": fingers,
                    "t_s": t_s,
                    "object_sd_k": round(float(_covariance(used, prior)[0, 0]) ** 0.5, 4),
                }
            )
    return rows


def _covariance(used: Sequence[Array], sd: Array) -> Array:
    """Return the covariance of temperature and ln effusivity; each finger's own parameters are eliminated."""
    shared = np.diag(sd[:SHARED] ** -2.0)
    for each in used:
        information = each.T @ each / reading_noise_k() ** 2
        own = information[SHARED:, SHARED:] + np.diag(sd[SHARED:] ** -2.0)
        mixed = information[:SHARED, SHARED:]
        shared = shared + information[:SHARED, :SHARED] - mixed @ np.linalg.solve(own, mixed.T)
    return np.asarray(np.linalg.inv(shared))
