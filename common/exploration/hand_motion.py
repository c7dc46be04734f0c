"""Motion of the hand over the bench, which all of its fingers share."""

from common.exploration.position_spread import PositionSpread
from common.exploration.stroke_speed import HandSpeed


class HandMotion:
    """Position, speed and position spread of one hand; step it before its fingers.

    Attributes:
        x_m, y_m: position along the bench and across it, m.
        speed_m_s: tangential speed, m/s, >= 0.
        spread: spread of the positions in the last quarter of a second.
    """

    def __init__(self) -> None:
        self.x_m = self.y_m = self.speed_m_s = 0.0
        self.spread = PositionSpread()
        self._estimate = HandSpeed()

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the position at `t_s`, s and m."""
        self.x_m, self.y_m = x_m, y_m
        self._estimate.step(t_s, x_m, y_m)
        self.speed_m_s = self._estimate.speed_m_s
        self.spread.step(t_s, x_m, y_m)
