"""What is known of a contact before it happens: when a finger that comes down will meet the surface below it.

Only where the place is known beforehand, as a virtual scene knows it. A plate of 2.5 K/s and a motor need some time;
what they do in the last moments before contact is theirs to be right in time, and too little to be felt.
"""

import math

from operator_site.skin import Touched
from operator_site.tissue import LAYERS

LEAD_S = 0.3
"""A plate starts so long before contact at most: the skin is 0.06 K colder, or 0.09 K warmer by then, and a tenth of a
kelvin is felt. A second would halve the error of cold metal, and be felt as 0.5 K before it is touched."""
SLOWEST_M_S = 0.01
"""A finger that comes down more slowly may as well stay up: tremor alone makes 2 mm/s."""

_EPIDERMIS = LAYERS[0]
_SKIN_EFFUSIVITY = math.sqrt(_EPIDERMIS.conductivity_w_mk * _EPIDERMIS.density_kg_m3 * _EPIDERMIS.specific_heat_j_kgk)


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
