"""Detects a plate that takes more heat than its reading explains: its thermistor comes off and reads too little.

Such a reading still follows the drive, so that the test of `plate_following` passes. But the plate becomes hotter than
it reads, and the finger takes more heat: a held reading then needs more and more drive. A sound plate needs less and
less, because its finger becomes warm.

The heat that the reading explains is that of a linear finger: after a step by 1 K it takes
`STEADY_PER_S + sum(g exp(-t/tau))`. Both terms are fitted to the three-layer finger of Kron & Schmidt 2003, Eq. 3 and
4, on the plate, from 0.02 to 300 s. All heat is given as the rate at which it would change the plate alone, K/s.
"""

import math

LOAD = ((0.45, 0.5), (0.155, 10.0))
"""Transient heat into the finger per change of the reading, 1/s, and its time constant, s."""
STEADY_PER_S = 0.05
"""Steady heat into finger, case and hot side per reading, 1/s."""
DRIVE_LAG_S = 0.1
"""Time constant of the reading behind the drive, s."""
SMOOTH_S = 2.0
"""Time constant of the smoothed excess, s."""
RATE_LAG_S = 0.3
"""Time constant of the smoothed rate of the reading, s."""
RATE_MEMORY_S = 5.0
"""Time constant with which the largest rate of the reading is forgotten, s."""
RATE_SHARE = 0.4
"""Error of the explained heat per recent rate of the reading; fingers, contacts and modules differ."""
RISE_K_S = 0.5
"""Rise of the excess that is a fault, K/s.

Simulated sound plates reach 0.3 in 100 minutes, with contact, heat capacity, drive, blood and water drawn at random.
"""
SETTLE_S = 8.0
"""Time with drive before the first judgement, s."""
ALIKE_S = 2.0
"""Time constant with which an undriven plate becomes as warm as its finger, s."""
FINGER_AWAY_C = 26.0
"""Reading of an undriven plate below which its finger may be away, and may be cold when it returns, C."""


class PlateLoad:
    """Heat of one plate beyond what its reading explains."""

    def __init__(self) -> None:
        self._power_k_s = self._rate_k_s = self._fastest_k_s = 0.0
        self._taken_k_s = [0.0] * len(LOAD)
        self._excess_k_s = 0.0
        self._least_k_s = math.inf
        self._age_s = self._driven_s = 0.0

    def step(self, dt_s: float, power_k_s: float, rate_k_s: float, plate_c: float) -> bool:
        """Return whether the plate takes too much heat.

        Args:
            dt_s: time since the last call, s.
            power_k_s: heat by the drive in this time, K/s.
            rate_k_s: rate of the reading in this time, K/s.
            plate_c: present reading, C.
        """
        self._power_k_s += (power_k_s - self._power_k_s) * dt_s / (DRIVE_LAG_S + dt_s)
        self._rate_k_s += (rate_k_s - self._rate_k_s) * dt_s / (RATE_LAG_S + dt_s)
        self._fastest_k_s = max(abs(self._rate_k_s), self._fastest_k_s * (1.0 - dt_s / RATE_MEMORY_S))
        excess_k_s = self._power_k_s - rate_k_s - STEADY_PER_S * plate_c
        driven = power_k_s != 0.0
        for term, (gain_per_s, fades_s) in enumerate(LOAD):
            lasts_s = fades_s if driven else min(fades_s, ALIKE_S)
            self._taken_k_s[term] += (gain_per_s * rate_k_s - self._taken_k_s[term] / lasts_s) * dt_s
            excess_k_s -= self._taken_k_s[term]
        self._age_s = min(SMOOTH_S, self._age_s + dt_s)  # the mean of all values at first
        self._excess_k_s += (excess_k_s - self._excess_k_s) * dt_s / self._age_s
        if not driven:
            if plate_c < FINGER_AWAY_C:
                self._least_k_s, self._driven_s = math.inf, 0.0
            return False
        self._driven_s = min(SETTLE_S, self._driven_s + dt_s)
        return self._driven_s >= SETTLE_S and self._rises()

    def _rises(self) -> bool:
        """Return whether the excess has risen above its least value by more than its error allows."""
        error_k_s = RATE_SHARE * self._fastest_k_s
        self._least_k_s = min(self._least_k_s, self._excess_k_s + error_k_s)
        return self._excess_k_s - error_k_s - self._least_k_s > RISE_K_S
