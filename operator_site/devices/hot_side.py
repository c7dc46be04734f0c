"""Watches the hot side of a fingertip module, from which water carries away the heat pumped out of the plate.

Without water the plate is cooled less than commanded. A block above about 75 C warms the plate to more than 42 C when
the drive stops. This takes ten minutes of full cooling. The block's temperature shows the loss within seconds, because
only water can hold it.
"""

import math

from common.buses.thermometry import ntc_c
from common.faults.fault import Fault, FaultCode
from operator_site.devices.ntc import ntc_fault

WARMEST_C = 30.0
COLDEST_C = 10.0
"""Limits of the hot side's temperature, C. The module's water has 15 to 25 C. Permanent full cooling adds 1.2 K (0.8
K/W, at most 1.5 W), full heating subtracts 0.4 K, and the thermistor errs by at most 1 K: 13.6 to 27.2 C is normal."""
MOVED_K = 2.5
"""Maximum difference from the mean of the last MEMORY_S, K; with water no drive causes more than 1.6 K."""
MEMORY_S = 60.0
"""Time constant of the mean, s."""


class HotSide:
    """Hot side of one module: `step` for each reading."""

    def __init__(self) -> None:
        self._t_s = math.nan
        self._usual_c = math.nan

    def step(self, t_s: float, counts: int) -> Fault | None:
        """Take the thermistor's counts at `t_s`, s; return the fault of the cooling, None without one."""
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
