"""Baseline: a local contact whose force changes smoothly when its model changes, without a limit on the energy.

It is the obvious first version, and it is stable. But a surface that appears above the finger raises the force at 50
N/s until the finger is out. Late models thus inject energy that nobody supplied.
"""

import math

from common.limits import FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S

STIFFEST_N_M = 400.0
"""Largest stiffness that a finger in an exoskeleton (0.1 kg, 3 Ns/m, 400 N/m) takes from a 500 Hz loop with 5 ms delay,
N/m."""


class BlendedContact:
    """Contact of one finger; `step` returns the force to display, N, 0..10."""

    def __init__(self) -> None:
        self._t_s = math.nan
        self._surface_m = self._stiffness_n_m = self._damping_n_s_m = 0.0
        self._blend_n = 0.0

    def step(
        self,
        t_s: float,
        z_m: float,
        surface_m: float,
        stiffness_n_m: float,
        damping_n_s_m: float = 0.0,
        approach_m_s: float = 0.0,
    ) -> float:
        """Force at `t_s` for a finger at height `z_m`; arguments as in the operator site's own contact."""
        dt_s = t_s - self._t_s
        self._t_s = t_s
        if not 0.0 < dt_s <= 0.1:
            dt_s = 0.0
        before = self._force(z_m, approach_m_s)
        self._surface_m, self._damping_n_s_m = surface_m, damping_n_s_m
        self._stiffness_n_m = min(max(0.0, stiffness_n_m), STIFFEST_N_M)
        self._blend_n += before - self._force(z_m, approach_m_s)
        if self._blend_n > 0.0:  # the old model pushed harder: ramp down fast
            self._blend_n = max(0.0, self._blend_n - FORCE_RAMP_DOWN_N_S * dt_s)
        else:
            self._blend_n = min(0.0, self._blend_n + FORCE_RAMP_UP_N_S * dt_s)
        return min(FINGER_FORCE_N, max(0.0, self._force(z_m, approach_m_s) + self._blend_n))

    def _force(self, z_m: float, approach_m_s: float) -> float:
        """Contact force k d + b approach, N, never negative."""
        depth_m = self._surface_m - z_m
        if depth_m <= 0.0 or self._stiffness_n_m == 0.0:
            return 0.0
        return max(0.0, self._stiffness_n_m * depth_m + self._damping_n_s_m * approach_m_s)
