"""The robot hand's servo along the bench: a critically damped second order."""

import math

HAND_RAD_S = 80.0
"""Its frequency, rad/s."""


def follow(dt_s: float, position: float, velocity: float, target: float) -> tuple[float, float]:
    """Place and speed `dt_s` later: the exact step towards a constant target."""
    away = position - target
    slope = velocity + HAND_RAD_S * away
    decay = math.exp(-HAND_RAD_S * dt_s)
    return (
        target + (away + slope * dt_s) * decay,
        (velocity - HAND_RAD_S * slope * dt_s) * decay,
    )
