"""Servo of the robot hand along the bench: a critically damped second-order system."""

import math

HAND_RAD_S = 80.0
"""Natural frequency of the hand's servo, rad/s."""


def follow(dt_s: float, position: float, velocity: float, target: float) -> tuple[float, float]:
    """Return position and velocity after `dt_s`: the exact solution for a constant target."""
    away = position - target
    slope = velocity + HAND_RAD_S * away
    decay = math.exp(-HAND_RAD_S * dt_s)
    return (
        target + (away + slope * dt_s) * decay,
        (velocity - HAND_RAD_S * slope * dt_s) * decay,
    )
