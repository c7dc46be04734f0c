"""The hot side of a fingertip module, from which water carries the heat that was pumped out of the plate.

Without water the plate is no longer cooled as it is driven, and a block that has become hot warms the plate when the
drive stops: from about 75 C on to more than 42 C. That takes ten minutes of full cooling, and the block's temperature
tells of it long before, so this one number is judged and nothing is expected of its course.
"""

from common.thermometry import ntc_c
from operator_site.ntc import ntc_fault

WARMEST_C = 30.0
COLDEST_C = 10.0
"""The module's water has 15 to 25 C. With it full cooling, for as long as one likes, adds 1.2 K (0.8 K/W and at most
1.5 W), full heating takes 0.4 K away, and the thermistor may be wrong by 1 K: 13.6 to 27.2 C is normal."""


def hot_side_fault(counts: int) -> str:
    """What is wrong with the cooling of a module whose hot side's thermistor reads `counts`; empty when nothing."""
    broken = ntc_fault(counts)
    if broken is not None:
        return f"the hot side's thermistor: {broken}"
    hot_side_c = ntc_c(counts)
    if hot_side_c > WARMEST_C:
        return f"the cooling water is lost: hot side at {hot_side_c:.0f} C"
    if hot_side_c < COLDEST_C:
        return f"the cooling water is too cold: hot side at {hot_side_c:.0f} C"
    return ""
