"""Presses on ground that breathes, with a nodule or none, and their numbers."""

import math

import numpy as np

from operator_site.palpation.inclusion_model import contact_radius_m, energy_share, ln_lift
from operator_site.palpation.nodule_search import PressNumbers
from studies.nodules.press_numbers import press_numbers
from tests.unit.operator_site.palpation.made_ground import grid_m

MIDDLE_M = (0.03, 0.03)
CONTACT_N, PROBE_M, SINCE_S = 0.075, 6e-3, 0.1 * np.arange(1, 9)


def pressed(breath_m: float, top_m: float | None = None) -> tuple[np.ndarray, ...]:
    """Places, depths, forces and times of contact of presses on breathing ground, with a nodule of 15 mm or none."""
    chance = np.random.default_rng(2)
    places_m = grid_m()
    away_m = np.hypot(*(places_m - MIDDLE_M).T)
    depth_m = 3e-3 * np.arange(1, 9) / 8
    contact_s = 1.5 * np.arange(len(places_m))
    start = 2.0 * math.pi * 15.0 / 60.0 * contact_s[:, None]
    rise_m = breath_m * (np.sin(start + 2.0 * math.pi * 15.0 / 60.0 * SINCE_S) - np.sin(start))
    contact_m = 1e-3
    force_n = CONTACT_N * ((depth_m + rise_m + contact_m) / contact_m) ** 2.0
    if top_m is not None:
        share = energy_share(away_m, top_m, 7.5e-3, contact_radius_m(PROBE_M, 2e-3))
        force_n *= np.exp(ln_lift(share, 8.0))[:, None]
    return places_m, depth_m, force_n * (1.0 + 0.01 * chance.normal(size=force_n.shape)), contact_s


def numbers_of(breath_m: float, top_m: float | None = None) -> PressNumbers:
    """Numbers of these presses."""
    places_m, depth_m, force_n, contact_s = pressed(breath_m, top_m)
    return press_numbers(places_m, depth_m, force_n, CONTACT_N, PROBE_M, SINCE_S, contact_s)
