"""Detects a plate whose reading rises too slowly for its heat, as when a thermal sensor comes off its plate.

Such a reading lies between plate and air. The plate is then hotter than it reads, and its reading answers the heater
with a smaller rate. The rate is judged only after a second and more of strong drive, when the sensor's lag and the
temperature of the last touch have no more effect. Moving air changes it little, because a strong drive heats faster
than air cools.
"""

STRONG_DRIVE = 0.5
"""Least drive at which the rate is judged, 0..1."""
SETTLE_S = 1.5
"""Time with strong drive before the first judgement, s; the slowest sensor lags by 0.5 s."""
LEAST_RATE_K_S = 2.8
"""Rate of the reading at full drive below which the heat goes elsewhere, K/s.

Simulated sound plates reach 3.7 K/s, and 2.8 K/s if they have a heat capacity of 130 %."""


class SlowHeating:
    """Strong drive of one heater, and whether its reading follows."""

    def __init__(self) -> None:
        self._strong_s = 0.0

    def step(self, dt_s: float, drive: float, rate_k_s: float) -> bool:
        """Return whether the reading rises too slowly, once for each SETTLE_S.

        Args:
            dt_s: time since the last call, s.
            drive: drive of the heater in this time, -1..1, positive heats.
            rate_k_s: present rate of the reading, K/s.
        """
        if drive < STRONG_DRIVE:
            self._strong_s = 0.0
            return False
        self._strong_s += dt_s
        if self._strong_s <= SETTLE_S or rate_k_s >= LEAST_RATE_K_S * drive:
            return False
        self._strong_s = 0.0
        return True
