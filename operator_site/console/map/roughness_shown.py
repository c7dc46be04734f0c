"""Converts a roughness from V to what people read: um in the calibrated range of the sensor, else a level of 0 to 10.

A level is logarithmic: 0 is LEVEL_0_V, and each level is a factor of about 1.6. It compares places, and no sensors.
"""

import math
from typing import NamedTuple

from common.wire.roughness_um import RoughnessUm

LEVEL_0_V, LEVEL_10_V = 0.002, 0.2
"""Roughness at the levels 0 and 10, V."""


class RoughnessShown(NamedTuple):
    """Roughness and its standard deviation in `unit`."""

    value: float
    sd: float
    unit: str


def roughness_shown(value_v: float, sd_v: float, scale: RoughnessUm | None) -> RoughnessShown:
    """Return a roughness as people read it.

    Args:
        value_v, sd_v: roughness and its standard deviation, V, above zero.
        scale: scale in um; None if the sensor was not calibrated for it.
    """
    relative = sd_v / value_v
    if scale is None or not scale.holds(value_v):
        per_ln = 10.0 / math.log(LEVEL_10_V / LEVEL_0_V)
        level = min(10.0, max(0.0, per_ln * math.log(value_v / LEVEL_0_V)))
        return RoughnessShown(level, per_ln * relative, "of 10")
    value_um = math.exp(scale.ln_um + scale.exponent * math.log(value_v))
    return RoughnessShown(value_um, value_um * math.hypot(scale.exponent * relative, scale.ln_sd), "µm")
