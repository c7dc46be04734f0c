"""How the hand moves over the bench: the same for all of its fingers."""

from common.exploration.position_spread import PositionSpread
from common.exploration.stroke_speed import HandSpeed


class HandMotion:
    """Speed and whereabouts of one hand; step it before its fingers.

    Attributes:
        x_m, y_m: where it is, along the bench and across it, m.
        speed_m_s: tangential speed, m/s, >= 0.
        whereabouts: where it was in the last quarter of a second.
    """

    __slots__ = ("_estimate", "speed_m_s", "whereabouts", "x_m", "y_m")

    def __init__(self) -> None:
        self.x_m = self.y_m = self.speed_m_s = 0.0
        self.whereabouts = PositionSpread()
        self._estimate = HandSpeed()

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the place at `t_s`, s and m."""
        self.x_m, self.y_m = x_m, y_m
        self._estimate.step(t_s, x_m, y_m)
        self.speed_m_s = self._estimate.speed_m_s
        self.whereabouts.step(t_s, x_m, y_m)
