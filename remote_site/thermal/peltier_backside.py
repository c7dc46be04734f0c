"""How far the back of a thermal sensor is from ambient, from what its heater has done.

What a Peltier element pumps into the plate it takes from its back in part, the rest is electric power. After some
touches, each with a plate heated anew, the backs of all fingers are therefore colder than at rest, and each touch
leaks more heat than those did that calibrated the sensor. The constants are those of the sensor's design (an element
of 2 W on a mount of 3 J/K); what a sensor of its own kind does otherwise is in the uncertainty.
"""

import math

HEATING_K_S = -0.22
"""Full drive that heats, K/s."""
COOLING_K_S = 0.67
"""Full drive that cools, K/s: there the electric power comes on top."""
WARMED_PER_S = 0.003
"""By the plate, part of the difference in a second."""
RECOVERS_PER_S = 0.011
"""Towards ambient, part of the difference in a second."""
UNSURE = 0.5
"""What the heater has done is known to this part of itself,"""
LEAST_SD_K = 0.6
"""and never better than this: sensors leak differently, and a session may begin with warm ones, K."""
LONGEST_S = 0.2
"""A hole in the readings counts as no longer than this: the drive is off by then."""


class PeltierBackside:
    """Back of one finger's sensor; step it with each reading.

    Attributes:
        above_k: mean temperature of what the plate leaks into, above ambient, K.
    """

    def __init__(self) -> None:
        """A sensor that has not been heated for minutes."""
        self.above_k = 0.0
        self._heater_k = 0.0

    def step(self, dt_s: float, drive: float, plate_k: float) -> None:
        """Take one reading.

        Args:
            dt_s: since the one before, s.
            drive: of the heater in that time, -1..1; above 0 heats.
            plate_k: plate above ambient, K.
        """
        dt_s = min(max(dt_s, 0.0), LONGEST_S)
        heater_k_s = drive * HEATING_K_S if drive > 0.0 else -drive * COOLING_K_S
        self._heater_k += dt_s * (heater_k_s - RECOVERS_PER_S * self._heater_k)
        self.above_k += dt_s * (heater_k_s + WARMED_PER_S * (plate_k - self.above_k) - RECOVERS_PER_S * self.above_k)

    @property
    def sd_k(self) -> float:
        """Standard deviation of `above_k`, K."""
        return math.hypot(LEAST_SD_K, UNSURE * self._heater_k)
