"""Estimates the temperature of a thermal sensor's back from the drive of its heater.

A Peltier element takes a part of the heat for the plate from its back; the rest is electric power. After some touches,
with the plate heated again before each, the backs of all fingers are therefore colder than at rest. Each touch then
leaks more heat than those in calibration. The constants belong to the sensor's design (an element of 2 W on a mount of
3 J/K). The uncertainty covers the differences between sensors of this kind.
"""

import math

HEATING_K_S = -0.22
"""Rate of the back's temperature at full heating drive, K/s."""
COOLING_K_S = 0.67
"""Rate of the back's temperature at full cooling drive, K/s; the electric power adds to the heat from the plate."""
WARMED_PER_S = 0.003
"""Rate at which the back approaches the plate, 1/s."""
RECOVERS_PER_S = 0.011
"""Rate at which the back approaches ambient, 1/s."""
UNSURE = 0.5
"""Standard deviation of the heater's effect on the back, as a fraction of the effect."""
LEAST_SD_K = 0.6
"""Minimum standard deviation of the back's temperature, K: sensors leak differently, and may be warm at the start."""
LONGEST_S = 0.2
"""Maximum time that one step counts for, s; after a longer gap in the readings the drive is off."""


class PeltierBackside:
    """Back of one finger's sensor; step it with each reading.

    Attributes:
        above_k: mean temperature of the back, into which the plate leaks, above ambient, K.
    """

    def __init__(self) -> None:
        """Begin with a sensor that has not been heated for minutes."""
        self.above_k = 0.0
        self._heater_k = 0.0

    def step(self, dt_s: float, drive: float, plate_k: float) -> None:
        """Take the plate above ambient, K, after `dt_s` at this drive of the heater, -1..1; positive values heat."""
        dt_s = min(max(dt_s, 0.0), LONGEST_S)
        heater_k_s = drive * HEATING_K_S if drive > 0.0 else -drive * COOLING_K_S
        self._heater_k += dt_s * (heater_k_s - RECOVERS_PER_S * self._heater_k)
        self.above_k += dt_s * (heater_k_s + WARMED_PER_S * (plate_k - self.above_k) - RECOVERS_PER_S * self.above_k)

    @property
    def sd_k(self) -> float:
        """Standard deviation of `above_k`, K."""
        return math.hypot(LEAST_SD_K, UNSURE * self._heater_k)
