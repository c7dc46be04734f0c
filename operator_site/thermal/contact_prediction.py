"""What is known of a contact before it happens: how fast a finger comes down, and when it will meet the surface.

Only where the place is known beforehand, as a virtual scene knows it. A plate of 2.5 K/s and a motor need some time;
what they do in the last moments before contact is theirs to be right in time, and too little to be felt.
"""

import math

from operator_site.thermal.skin_model import Touched
from operator_site.thermal.tissue import LAYERS

LEAD_S = 0.3
"""A plate starts so long before contact at most: the skin is 0.06 K colder, or 0.09 K warmer by then, and a tenth of a
kelvin is felt. A second would halve the error of cold metal, and be felt as 0.5 K before it is touched."""
SPEED_LAG_S = 0.008
"""Low-pass of the speed."""
LONGEST_STEP_S = 0.1
SLOWEST_M_S = 0.01
"""A finger that comes down more slowly may as well stay up: tremor alone makes 2 mm/s."""

_EPIDERMIS = LAYERS[0]
_SKIN_EFFUSIVITY = math.sqrt(_EPIDERMIS.conductivity_w_mk * _EPIDERMIS.density_kg_m3 * _EPIDERMIS.specific_heat_j_kgk)


class ContactPrediction:
    """How fast one finger comes down, out of its heights: they are quantised, 5 um in 2 ms are 2.5 mm/s."""

    __slots__ = ("_t_s", "_z_m", "m_s")

    def __init__(self) -> None:
        self._t_s = self._z_m = math.nan
        self.m_s = 0.0
        """The last result, m/s: positive downwards."""

    def step(self, t_s: float, z_m: float) -> float:
        """Speed downwards at `t_s` of a finger at height `z_m`, smoothed, m/s; 0 after a pause."""
        dt_s, descent_m = t_s - self._t_s, self._z_m - z_m
        self._t_s, self._z_m = t_s, z_m
        if 0.0 < dt_s <= LONGEST_STEP_S and math.isfinite(descent_m):
            self.m_s += (descent_m / dt_s - self.m_s) * dt_s / (SPEED_LAG_S + dt_s)
        else:
            self.m_s = 0.0
        return self.m_s


def contact_in_s(height_m: float, approach_m_s: float) -> float:
    """Time until a finger at `height_m` over the surface meets it, s; infinite where it does not come down.

    Args:
        height_m: above the surface; none is left below it.
        approach_m_s: speed towards it.
    """
    if not approach_m_s >= SLOWEST_M_S:
        return math.inf
    return max(0.0, height_m) / approach_m_s


def contact_c(skin_c: float, touched: Touched, object_c: float) -> float:
    """Temperature at which skin and object will meet, C: two half spaces, by their effusivities (Carslaw & Jaeger)."""
    effusivity = math.sqrt(touched.conductivity_w_mk * touched.density_kg_m3 * touched.specific_heat_j_kgk)
    return (_SKIN_EFFUSIVITY * skin_c + effusivity * object_c) / (_SKIN_EFFUSIVITY + effusivity)
