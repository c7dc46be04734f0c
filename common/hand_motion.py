"""How the hand moves over the bench: the same for all of its fingers."""

from common.motion_estimate import MotionEstimate
from common.whereabouts import Whereabouts


class HandMotion:
    """Speed and whereabouts of one hand; step it before its fingers.

    Attributes:
        x_m, y_m: where it is, along the bench and across it, m.
        whereabouts: where it was in the last quarter of a second.
    """

    __slots__ = ("_estimate", "whereabouts", "x_m", "y_m")

    def __init__(self) -> None:
        self.x_m = self.y_m = 0.0
        self.whereabouts = Whereabouts()
        self._estimate = MotionEstimate()

    @property
    def speed_m_s(self) -> float:
        """Tangential speed, m/s, >= 0."""
        return self._estimate.speed_m_s

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the place at `t_s`, s and m."""
        self.x_m, self.y_m = x_m, y_m
        self._estimate.step(t_s, x_m, y_m)
        self.whereabouts.step(t_s, x_m, y_m)
