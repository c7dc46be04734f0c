"""Controls a free thermal sensor's plate to an offset above ambient temperature.

Kron & Schmidt 2003, section 4.2: the plate is heated before a contact and not during it. The patient-side gate limits
the drive; this controller requests nothing that the gate would refuse.
"""

from common.limits import DOSE_ABOVE_C, SENSOR_PLATE_C
from common.wire.messages import ThermalReason

OFFSETS_K = (10.0, 17.0, 3.0)
"""Offsets above ambient temperature, K, in the order in which they are tried on an object without a difference."""
STAGGER_K = (0.0, -4.0, -7.0, -4.0, -7.0)
"""Changes of the first offset for the first, second, ... finger in use, K.

Plates of different temperatures on one object separate its temperature from its effusivity at once; one plate cannot.
All others are cooler than the first, because plates warm up between two touches, and a plate that is still heated at
contact shows little. There are two cooler offsets, because after a cold object only these plates have come to rest.
"""
MARGIN_K = 0.5
"""Minimum distance of a chosen offset's temperature below the plate's limit, K."""
STALE_S = 0.10
"""Age from which a reading drives no heater, s."""
GAIN_PER_K = 0.8
"""Proportional gain, 1/K."""
INTEGRAL_PER_K_S = 0.3
"""Integral gain, 1/(K s)."""
INTEGRATE_WITHIN_K = 0.5
"""Largest error that is integrated, K; the integral does not wind up during heating."""
INTEGRAL_MOST = 0.3
"""Largest share of the integral in the drive, 0..1."""
LEAD_S = 0.3
"""Time by which the slope of the reading extrapolates it, s; the read-out lags by about this time."""
SLOPE_S = 0.10
"""Time constant of the low-pass filter of that slope, s."""


def next_offset_k(offset_k: float, ambient_c: float) -> float:
    """Return the offset to try after `offset_k` gave no difference, K; an offset beyond the plate's limit is skipped.

    If even the smallest offset is beyond the limit, the answer is the smallest. The controller holds no plate above
    DOSE_ABOVE_C.
    """
    start = OFFSETS_K.index(offset_k) if offset_k in OFFSETS_K else 0
    for k in range(1, len(OFFSETS_K) + 1):
        offset = OFFSETS_K[(start + k) % len(OFFSETS_K)]
        if ambient_c + offset <= SENSOR_PLATE_C - MARGIN_K:
            return offset
    return min(OFFSETS_K)


class HeaterControl:
    """Controller of one finger's heater; step it at 100 Hz or faster."""

    def __init__(self, offset_k: float = OFFSETS_K[0]) -> None:
        """Begin with an offset above ambient temperature, K; `offset_k` may be changed at any time."""
        self.offset_k = offset_k
        self._before_s: float | None = None
        self._before_c = 0.0
        self._slope_k_s = 0.0
        self._integral = 0.0

    def step(
        self,
        t_s: float,
        sensor_c: float,
        ambient_c: float,
        in_contact: bool,
        fault: ThermalReason = ThermalReason.NONE,
    ) -> float:
        """Return the heater drive, -1..1, negative cools; 0 in contact and for an implausible reading.

        Args:
            t_s: time of the reading, s.
            sensor_c: temperature of the plate, C.
            ambient_c: ambient temperature, C.
            in_contact: whether the finger touches an object.
            fault: why the reading is implausible.
        """
        plausible = not fault and 0.0 < sensor_c < SENSOR_PLATE_C and 0.0 < ambient_c < SENSOR_PLATE_C
        if in_contact or not plausible:
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
        target_c = min(ambient_c + self.offset_k, DOSE_ABOVE_C)  # a waiting plate must take no dose
        error_k = target_c - (sensor_c + LEAD_S * self._slope_k_s)
        if abs(error_k) < INTEGRATE_WITHIN_K:
            integral = self._integral + INTEGRAL_PER_K_S * error_k * dt_s
            self._integral = min(max(integral, -INTEGRAL_MOST), INTEGRAL_MOST)
        return min(max(GAIN_PER_K * error_k + self._integral, -1.0), 1.0)
