"""Detects a plate that takes too much drive to hold its reading, as when a thermal sensor loosens on a warm plate.

Such a reading lies between plate and air. The heater holds the reading, so that the plate is hotter than it reads and
loses more heat. Heat goes to the air, the case and the back side in proportion to the difference from the air. The
drive for each kelvin of the reading is therefore that of a sound plate, divided by the remaining contact.
"""

import math

WINDOW_S = 2.0
"""Time over which drive and reading are averaged, s; a first window after a pause of the drive is not judged."""
MOST_RISE_K, MOST_FALL_K = 0.1, 0.3
"""Largest change of the reading in a window that holds a temperature, K. A rise takes drive of its own."""
MOST_DRIVE_PER_K = 0.0125
"""Drive for each kelvin above the air beyond which a plate loses too much heat, 1/K.

Simulated sound plates take 0.0086 at most, and 0.0117 in air that carries off four times as much heat."""
LEAST_DRIVE = 0.0625
"""Mean drive up to which no plate is found, 0..1; it warms a sound plate by 9 K."""


class HoldingLoss:
    """Drive and reading of one plate, averaged over windows."""

    def __init__(self) -> None:
        self._begin(settled=False)

    def _begin(self, *, settled: bool) -> None:
        """Begin a window; it is judged if the plate has settled since a pause of the drive."""
        self._settled = settled
        self._from_k = math.nan
        self._passed_s = self._drive_s = self._above_k_s = 0.0

    def step(self, dt_s: float, drive: float, above_k: float) -> bool:
        """Return whether the plate takes too much drive, at the end of a window.

        Args:
            dt_s: time since the last call, s.
            drive: drive of the heater in this time, -1..1, positive heats; 0 is a pause.
            above_k: reading of the plate above that of the air, K; NaN if one is unknown.
        """
        if not drive or math.isnan(above_k):
            self._begin(settled=False)
            return False
        if math.isnan(self._from_k):
            self._from_k = above_k
        self._passed_s += dt_s
        self._drive_s += drive * dt_s
        self._above_k_s += above_k * dt_s
        if self._passed_s < WINDOW_S:
            return False
        held = -MOST_FALL_K <= above_k - self._from_k <= MOST_RISE_K
        most_s = max(MOST_DRIVE_PER_K * self._above_k_s, LEAST_DRIVE * self._passed_s)
        lost = self._settled and held and self._drive_s > most_s
        self._begin(settled=True)
        return lost
