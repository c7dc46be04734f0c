"""How surfaces are explored: come down, rest, stroke evenly; alike over real, virtual and remote ones."""

import numpy as np

from studies.simulated_finger import Array

SPEED_M_S = 0.050
SLOW_M_S = 0.030
"""People choose their speed; at this one, grooves 2 mm apart come at 15 Hz."""
FORCE_N = 1.0
START_M = 0.010
"""Where the finger comes down, from the surface's near edge."""
HOVER_S = 0.1
"""From the start to the finger's coming down."""
REST_S = 0.6
"""From the start to the stroke."""
STROKE_S = 3.0
MEASURED_FROM_S = REST_S + 0.5
"""By then the motor has its speed, and the remote site knows the surface."""
SECONDS = REST_S + STROKE_S
LENGTH_M = START_M + SPEED_M_S * STROKE_S + 0.010


def place_m(time_s: float, speed_m_s: float = SPEED_M_S) -> float:
    """Place along the surface."""
    return START_M + speed_m_s * max(0.0, time_s - REST_S)


def measured(course: Array, tick_s: float) -> Array:
    """The part of a course of one value a tick that is judged."""
    return np.asarray(course[round(MEASURED_FROM_S / tick_s) :])
