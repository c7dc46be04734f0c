"""Closed loop that keeps the thermal sensor's plate at an offset above ambient while it is free.

Kron & Schmidt 2003, section 4.2: heated before, switched off at contact. The patient-side gate has the
last word; this loop never asks for what the gate would refuse.
"""

from common.limits import SENSOR_PLATE_C
from common.wire.messages import ThermalReason

OFFSETS_K = (10.0, 17.0, 3.0)
"""Pre-heat above ambient, K, in the order in which they are tried on an object that offers no difference."""
STAGGER_K = (0.0, -4.0, -7.0, -4.0, -7.0)
"""What is added to the first of them for the first, second, ... finger in use, K: plates of different warmth on one
object tell its temperature at once; one plate alone cannot tell it from its effusivity. Cooler ones, since plates are
warmed between two touches, and one that is still being heated when it touches tells little. Two kinds of cooler ones,
since after a cold object these alone have come to rest, and must differ among themselves."""
MARGIN_K = 0.5
"""Set-points stay this far below the plate's limit, K."""
STALE_S = 0.10
GAIN_PER_K = 0.8
INTEGRAL_PER_K_S = 0.3
INTEGRATE_WITHIN_K = 0.5
"""The integral only removes what the proportional part leaves; it does not wind up on the way, K."""
LEAD_S = 0.3
"""The read-out lags by about this, s; the slope of the reading makes up for it."""
SLOPE_S = 0.10
"""Smoothing of that slope, s."""


def next_offset_k(offset_k: float, ambient_c: float) -> float:
    """The pre-heat to use after `offset_k` gave no difference, K; skips what would pass the plate's limit.

    Where even the smallest offset passes the limit the answer is the smallest: the loop then holds the limit.
    """
    start = OFFSETS_K.index(offset_k) if offset_k in OFFSETS_K else 0
    for k in range(1, len(OFFSETS_K) + 1):
        offset = OFFSETS_K[(start + k) % len(OFFSETS_K)]
        if ambient_c + offset <= SENSOR_PLATE_C - MARGIN_K:
            return offset
    return min(OFFSETS_K)


class HeaterControl:
    """Heater loop of one finger; step it at 100 Hz or faster."""

    __slots__ = ("_before_c", "_before_s", "_integral", "_slope_k_s", "offset_k")

    def __init__(self, offset_k: float = OFFSETS_K[0]) -> None:
        """Begin with the given pre-heat above ambient, K; `offset_k` may be changed at any time."""
        self.offset_k = offset_k
        self._before_s: float | None = None
        self._before_c = 0.0
        self._slope_k_s = 0.0
        self._integral = 0.0

    def step(
        self,
        t_s: float,
        sensor_c: float | None,
        ambient_c: float | None,
        in_contact: bool,
        *,
        age_s: float = 0.0,
        fault: ThermalReason = ThermalReason.NONE,
    ) -> float:
        """Return the heater drive, -1..1 (negative cools); 0 in contact and whenever in doubt.

        Args:
            t_s: time of the reading, s.
            sensor_c: plate, C; None where there is no reading.
            ambient_c: ambient sensor, C; None where there is no reading.
            in_contact: whether the finger touches anything.
            age_s: age of the reading, s.
            fault: what makes the reading implausible, if anything.
        """
        believable = (
            not fault
            and sensor_c is not None
            and ambient_c is not None
            and age_s <= STALE_S
            and 0.0 < sensor_c < SENSOR_PLATE_C
            and 0.0 < ambient_c < SENSOR_PLATE_C
        )
        if in_contact or not believable or sensor_c is None or ambient_c is None:
            self._before_s = None
            self._integral = 0.0
            self._slope_k_s = 0.0
            return 0.0
        if self._before_s is not None and t_s > self._before_s:
            dt_s = t_s - self._before_s
            part = dt_s / (SLOPE_S + dt_s)
            self._slope_k_s += part * ((sensor_c - self._before_c) / dt_s - self._slope_k_s)
        else:
            dt_s = 0.0
        self._before_s, self._before_c = t_s, sensor_c
        target_c = min(ambient_c + self.offset_k, SENSOR_PLATE_C - MARGIN_K)
        error_k = target_c - (sensor_c + LEAD_S * self._slope_k_s)
        if abs(error_k) < INTEGRATE_WITHIN_K:
            self._integral = min(max(self._integral + INTEGRAL_PER_K_S * error_k * dt_s, -0.3), 0.3)
        return min(max(GAIN_PER_K * error_k + self._integral, -1.0), 1.0)
