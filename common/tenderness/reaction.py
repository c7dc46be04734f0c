"""Estimates a patient's reaction time from presses with a reported pain.

A report begins and ends one reaction time after the force has crossed the patient's threshold. The right reaction time
makes the forces at both crossings equal.
"""

import numpy as np

from common.tenderness.presses import LATEST_S, PRESSED_N, SOONEST_S, Press

REACTIONS_S = np.linspace(SOONEST_S, LATEST_S, 19)
"""Possible reaction times, s."""
CROSSING_SD = 0.3
"""Standard deviation of the logarithm of the ratio of both crossings' forces."""
OUTLIERS = 0.2
"""Share of presses whose report does not end with the force, such as after a lasting pain."""
_LEAST_N = 0.1
"""Force that is added to both crossings, N: below it a ratio says nothing."""
_OUTLIER_DENSITY = 0.5


class ReactionTime:
    """Probabilities of the possible reaction times; all are equal at first.

    Attributes:
        probabilities: of each of `REACTIONS_S`; their sum is 1.
    """

    def __init__(self) -> None:
        self._log = np.zeros(REACTIONS_S.size)
        self.probabilities = np.full(REACTIONS_S.size, 1.0 / REACTIONS_S.size)

    def learn(self, press: Press) -> None:
        """Take a press whose report has begun and ended."""
        rising, falling = (press.forces_n(t_s - REACTIONS_S).max(axis=1) for t_s in (press.risen_s, press.fallen_s))
        apart = np.log((rising + _LEAST_N) / (falling + _LEAST_N)) / CROSSING_SD
        density = np.exp(-0.5 * apart**2) / (CROSSING_SD * np.sqrt(2.0 * np.pi))
        self._log += np.log((1.0 - OUTLIERS) * density + OUTLIERS * _OUTLIER_DENSITY)
        weights = np.exp(self._log - self._log.max())
        self.probabilities = weights / weights.sum()

    @property
    def mean_s(self) -> float:
        """Expected reaction time, s."""
        return float(self.probabilities @ REACTIONS_S)

    @property
    def sd_s(self) -> float:
        """Standard deviation of the reaction time, s."""
        return float(np.sqrt(self.probabilities @ (REACTIONS_S - self.mean_s) ** 2))

    def threshold_n(self, press: Press, share: float) -> float:
        """Return the force, N, above which the reported pain began with the probability `share`, 0..1.

        Of several fingers, the one that presses least counts.
        """
        forces = press.forces_n(press.risen_s - REACTIONS_S)
        forces_n = np.where(forces >= PRESSED_N, forces, np.inf).min(axis=1)
        touched = np.isfinite(forces_n)  # no pain begins before the touch
        if not touched.any():
            return 0.0
        forces_n, weights = forces_n[touched], self.probabilities[touched]
        order = np.argsort(forces_n)
        reached = np.cumsum(weights[order]) >= share * weights.sum()
        return float(forces_n[order][np.argmax(reached)])
