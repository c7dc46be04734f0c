"""Converts counts to temperatures: the remote sensor's spreading-resistance thermometer and the plate's NTC."""

import math

COUNT_MAX = 4095

SSR_R25_OHM = 1000.0
_SSR_A, _SSR_B = 7.874e-3, 1.874e-5
SSR_OHM_AT_0 = 814.9
"""Resistance of the sensor at 0 counts (0 C), ohm."""
SSR_OHM_AT_FULL = 1298.5
"""Resistance of the sensor at 4095 counts (60 C), ohm."""

NTC_R25_OHM = 10_000.0
NTC_B_K = 3950.0
NTC_SERIES_OHM = 10_000.0


def ssr_c(counts: float) -> float:
    """Return the temperature of a spreading-resistance sensor (KTY81 class) from its 12-bit counts, C.

    R(T) = R25 (1 + 7.874e-3 dT + 1.874e-5 dT^2), dT = T - 25 C, solved for T.
    """
    ohm = SSR_OHM_AT_0 + counts / COUNT_MAX * (SSR_OHM_AT_FULL - SSR_OHM_AT_0)
    return 25.0 + (math.sqrt(_SSR_A**2 + 4.0 * _SSR_B * (ohm / SSR_R25_OHM - 1.0)) - _SSR_A) / (2.0 * _SSR_B)


def ntc_c(counts: float) -> float:
    """Return the temperature of a 10 kOhm, B = 3950 K NTC below a 10 kOhm resistor from its 12-bit counts, C.

    Raises:
        ValueError: the counts are at an end of the scale, so the NTC is open or shorted.
    """
    if not 0 < counts < COUNT_MAX:
        raise ValueError(f"NTC counts {counts:g}: thermistor open or shorted")
    ohm = NTC_SERIES_OHM * counts / (COUNT_MAX - counts)
    return 1.0 / (1.0 / 298.15 + math.log(ohm / NTC_R25_OHM) / NTC_B_K) - 273.15
