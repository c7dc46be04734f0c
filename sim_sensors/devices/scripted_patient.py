"""A simulated patient who moves the pain slider one reaction time after a press exceeds the threshold of its place."""

import math
from collections import deque
from collections.abc import Sequence

from common.scenes.tender import TenderSpot

_LEAST = 0.2
"""Position of the slider when the threshold is just exceeded, 0..1; 1 at twice the threshold."""


class ScriptedPatient:
    """Answers with the slider.

    Attributes:
        pain: position of the slider, 0..1.
    """

    def __init__(self, spots: Sequence[TenderSpot], reaction_s: float) -> None:
        """Feel pain at these spots, and react after this time, s."""
        self._spots, self._reaction_s = spots, reaction_s
        self._felt: deque[tuple[float, float]] = deque()
        self.pain = 0.0

    def step(self, now_s: float, x_m: float, y_m: Sequence[float], force_n: Sequence[float]) -> None:
        """Take the forces of the fingers at their places on the patient, at `now_s`."""
        load = max((self._load(x_m, *finger) for finger in zip(y_m, force_n, strict=True)), default=0.0)
        self._felt.append((now_s, 0.0 if load < 1.0 else min(1.0, _LEAST + (1.0 - _LEAST) * (load - 1.0))))
        while self._felt and self._felt[0][0] <= now_s - self._reaction_s:
            self.pain = self._felt.popleft()[1]

    def _load(self, x_m: float, y_m: float, force_n: float) -> float:
        """Return the force as a share of the threshold at its place."""
        return max((force_n / _threshold_n(spot, x_m, y_m) for spot in self._spots), default=0.0)


def _threshold_n(spot: TenderSpot, x_m: float, y_m: float) -> float:
    away2 = (x_m - spot.x_m) ** 2 + (y_m - spot.y_m) ** 2
    return spot.surround_n - (spot.surround_n - spot.threshold_n) * math.exp(-0.5 * away2 / spot.width_m**2)
