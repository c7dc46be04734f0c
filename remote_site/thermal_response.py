"""The measured course of one touch: drops of the plate at the table's times, and the fit of Eq. 11.

Calibration and identification read a touch through this one class, so that both see the same figures.
"""

from collections import deque
from collections.abc import Sequence

from remote_site.exponential_response import ExponentialFit, ExponentialResponse

AVERAGE = 10
"""Readings averaged into one drop (0.1 s)."""
HALF_SAMPLE_S = 0.0051
"""A drop at t uses no reading later than t; it is taken up to half a sample early."""
GAP_S = 0.15
"""A longer hole in the readings ends a touch, s."""


class ThermalResponse:
    """Course of one touch from contact on.

    Attributes:
        drops_k: drop of the plate below its start at each time reached, K.
    """

    __slots__ = ("_before_s", "_contact_s", "_exponential", "_recent", "_start_c", "_times_s", "drops_k")

    def __init__(self, contact_s: float, start_c: float, times_s: Sequence[float]) -> None:
        """Begin at contact.

        Args:
            contact_s: time of contact, s.
            start_c: plate there, C.
            times_s: times after contact at which a drop is taken, s, ascending.
        """
        self._contact_s = self._before_s = contact_s
        self._start_c = start_c
        self._times_s = times_s
        self._recent: deque[float] = deque(maxlen=AVERAGE)
        self._exponential = ExponentialResponse(start_c)
        self.drops_k: list[float] = []

    @property
    def complete(self) -> bool:
        """Whether the last time has been reached."""
        return len(self.drops_k) == len(self._times_s)

    def step(self, t_s: float, sensor_c: float) -> bool:
        """Take the plate's temperature, C, at `t_s`; returns whether a drop was completed.

        Raises:
            ValueError: the readings have a hole of more than GAP_S, or go back in time.
        """
        dt_s = t_s - self._before_s
        if not 0.0 <= dt_s <= GAP_S:
            raise ValueError(f"thermal readings missing before {t_s:.3f} s")
        self._before_s = t_s
        since_s = t_s - self._contact_s
        self._recent.append(self._start_c - sensor_c)
        self._exponential.add(since_s, sensor_c)
        if self.complete or since_s < self._times_s[len(self.drops_k)] - HALF_SAMPLE_S:
            return False
        self.drops_k.append(sum(self._recent) / len(self._recent))
        return True

    def fit(self) -> ExponentialFit | None:
        """Eq. 11 fitted to the readings so far."""
        return self._exponential.fit()
