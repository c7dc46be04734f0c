"""Defines the exploration of a surface: come down, rest, stroke steadily; the same on real, virtual and remote ones."""

import numpy as np

from studies.touches.simulated_finger import Array
from teletaction.testbed.rendered_fingers import TICK_S

SPEED_M_S = 0.050
SLOW_M_S = 0.030
"""Slow stroke speed, m/s; at this speed, grooves 2 mm apart come at 15 Hz. People choose their own speed."""
FORCE_N = 1.0
START_M = 0.010
"""Place at which the finger comes down, m from the surface's near edge."""
HOVER_S = 0.1
"""Time from the start until the finger comes down, s."""
REST_S = 0.6
"""Time from the start until the stroke, s."""
STROKE_S = 3.0
MEASURED_FROM_S = REST_S + 0.5
"""Start of the measured part, s; the motor has then reached its speed, and the remote site knows the surface."""
SECONDS = REST_S + STROKE_S
LENGTH_M = START_M + SPEED_M_S * STROKE_S + 0.010


def place_m(time_s: float, speed_m_s: float = SPEED_M_S) -> float:
    """Return the place along the surface, m."""
    return START_M + speed_m_s * max(0.0, time_s - REST_S)


def measured(course: Array) -> Array:
    """Return the judged part of a course of one value per tick."""
    return np.asarray(course[round(MEASURED_FROM_S / TICK_S) :])
