"""The hot side of a fingertip module, from which water carries the heat that was pumped out of the plate.

Without water the plate is no longer cooled as it is driven, and a block that has become hot warms the plate when the
drive stops: from about 75 C on to more than 42 C. That takes ten minutes of full cooling; the block tells of it within
seconds, since only water can hold its temperature.
"""

import math

from common.buses.thermometry import ntc_c
from common.faults.fault import Fault, FaultCode
from operator_site.devices.ntc import ntc_fault

WARMEST_C = 30.0
COLDEST_C = 10.0
"""The module's water has 15 to 25 C. With it full cooling, for as long as one likes, adds 1.2 K (0.8 K/W and at most
1.5 W), full heating takes 0.4 K away, and the thermistor may be wrong by 1 K: 13.6 to 27.2 C is normal."""
MOVED_K = 2.5
MEMORY_S = 60.0
"""With water, no drive moves it further from where it was in the last minute than 1.6 K."""


class HotSide:
    """One module's hot side over time: `step` for each reading."""

    def __init__(self) -> None:
        self._t_s = math.nan
        self._usual_c = math.nan

    def step(self, t_s: float, counts: int) -> Fault | None:
        """What is wrong with the cooling when the thermistor reads `counts` at `t_s`; None when nothing."""
        broken = ntc_fault(counts, FaultCode.HOT_SIDE_THERMISTOR_SHORT, FaultCode.HOT_SIDE_THERMISTOR_OPEN)
        if broken is not None:
            return Fault(broken)
        hot_side_c = ntc_c(counts)
        since_s, self._t_s = t_s - self._t_s, t_s
        if not 0.0 <= since_s <= MEMORY_S:
            self._usual_c = hot_side_c
        else:
            self._usual_c += (hot_side_c - self._usual_c) * since_s / (MEMORY_S + since_s)
        if hot_side_c > WARMEST_C or hot_side_c - self._usual_c > MOVED_K:
            return Fault(FaultCode.COOLING_LOST, value=hot_side_c, limit=self._usual_c)
        if hot_side_c < COLDEST_C or self._usual_c - hot_side_c > MOVED_K:
            return Fault(FaultCode.COOLING_TOO_COLD, value=hot_side_c, limit=self._usual_c)
        return None
