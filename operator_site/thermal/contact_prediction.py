"""Predicts a contact: the speed of the approaching finger, and the time and temperature of contact.

The prediction needs a surface that is known beforehand, as in a virtual scene. A plate of 2.5 K/s and a motor need
time to reach their values. They start just before contact, and their change until then is too small to be felt.
"""

import math

from operator_site.thermal.skin_model import Touched
from operator_site.thermal.tissue import LAYERS

LEAD_S = 0.3
"""Longest time before contact at which a plate starts, s.

It cools the skin by 0.06 K or warms it by 0.09 K until contact, and a tenth of a kelvin can be felt. With 1 s the error
of cold metal would halve, but 0.5 K would be felt before contact.
"""
SPEED_LAG_S = 0.008
"""Time constant of the low-pass filter of the speed, s."""
LONGEST_STEP_S = 0.1
"""Longest step over which a speed is measured, s."""
SLOWEST_M_S = 0.01
"""Smallest speed that predicts a contact, m/s; tremor alone reaches 2 mm/s."""

_EPIDERMIS = LAYERS[0]
_SKIN_EFFUSIVITY = math.sqrt(_EPIDERMIS.conductivity_w_mk * _EPIDERMIS.density_kg_m3 * _EPIDERMIS.specific_heat_j_kgk)


class ContactPrediction:
    """Estimates the downward speed of one finger from its quantised heights, of which 5 um in 2 ms are 2.5 mm/s."""

    def __init__(self) -> None:
        self._t_s = self._z_m = math.nan
        self.m_s = 0.0
        """Last result, m/s, positive downwards."""

    def step(self, t_s: float, z_m: float) -> float:
        """Return the smoothed downward speed at `t_s` of a finger at height `z_m`, m/s; 0 after a pause."""
        dt_s, descent_m = t_s - self._t_s, self._z_m - z_m
        self._t_s, self._z_m = t_s, z_m
        if 0.0 < dt_s <= LONGEST_STEP_S and math.isfinite(descent_m):
            self.m_s += (descent_m / dt_s - self.m_s) * dt_s / (SPEED_LAG_S + dt_s)
        else:
            self.m_s = 0.0
        return self.m_s


def contact_in_s(height_m: float, approach_m_s: float) -> float:
    """Return the time until contact, s; 0 below the surface, and infinite below SLOWEST_M_S."""
    if not approach_m_s >= SLOWEST_M_S:
        return math.inf
    return max(0.0, height_m) / approach_m_s


def contact_c(skin_c: float, touched: Touched, object_c: float) -> float:
    """Return the contact temperature of skin and object, C: two half spaces by effusivity (Carslaw & Jaeger)."""
    effusivity = math.sqrt(touched.conductivity_w_mk * touched.density_kg_m3 * touched.specific_heat_j_kgk)
    return (_SKIN_EFFUSIVITY * skin_c + effusivity * object_c) / (_SKIN_EFFUSIVITY + effusivity)
