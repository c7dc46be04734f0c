"""Simulate a remote fingertip: a mass on a position servo that presses on an elastic object.

    m z'' = K (z_set - z) - B z' + F,    F = k d (1 + a d') where d = depth below the object's surface, never negative

The damping of the object grows with depth (after Hunt & Crossley 1975), so force has no jump at contact.
The code uses plain floats: five fingertips cost less than numpy calls on arrays of five.
"""

import math
from functools import lru_cache

MASS_KG = 0.05
SERVO_N_M = 1000.0
SERVO_NS_M = 15.0
OBJECT_DAMPING_S_M = 1.5
SUBSTEP_S = 0.0005
LOW_Z_M = -0.010
"""Lower mechanical limit of the finger's height, m."""
HIGH_Z_M = 0.01046
"""Upper mechanical limit of the finger's height, m."""


class Fingertip:
    """Height and contact force of one finger; `approach_m_s` is its downward speed at the last contact."""

    def __init__(self, z_m: float) -> None:
        self.z_m = z_m
        self.velocity_m_s = 0.0
        self.force_n = 0.0
        self.approach_m_s = 0.0

    def step(self, dt_s: float, setpoint_z_m: float, surface_z_m: float, stiffness_n_m: float) -> None:
        """Advance by `dt_s`; a `stiffness_n_m` of 0 means that there is no object below.

        The substeps are semi-implicit: they take the servo's damping at the new velocity. They are stable up to
        stiffnesses of 100 kN/m.
        """
        substeps, h, decay, gain = _substeps(dt_s)
        target = min(max(setpoint_z_m, LOW_Z_M), HIGH_Z_M)
        z, v, force = self.z_m, self.velocity_m_s, self.force_n
        for _ in range(substeps):
            v = (v + gain * (SERVO_N_M * (target - z) + force)) * decay
            z += h * v
            depth = surface_z_m - z
            if depth > 0.0 and stiffness_n_m > 0.0:
                if force <= 0.0:
                    self.approach_m_s = max(0.0, -v)
                force = stiffness_n_m * depth * (1.0 - OBJECT_DAMPING_S_M * v)
                force = max(force, 0.0)
            else:
                force = 0.0
        self.z_m, self.velocity_m_s, self.force_n = z, v, force


@lru_cache(maxsize=8)
def _substeps(dt_s: float) -> tuple[int, float, float, float]:
    """Return the number of substeps of a step, the length of each, s, and its decay and gain."""
    substeps = max(1, math.ceil(dt_s / SUBSTEP_S - 1e-9))
    h = dt_s / substeps
    return substeps, h, 1.0 / (1.0 + h * SERVO_NS_M / MASS_KG), h / MASS_KG


def pressing_depth_m(force_n: float, stiffness_n_m: float) -> float:
    """Return the set-point's depth below the surface that gives the static contact force `force_n`, m."""
    return force_n * (1.0 / SERVO_N_M + 1.0 / stiffness_n_m)
