"""Force on one finger as a local contact with the streamed model: stiffness and surface, never force samples.

The law runs at the loop's own rate on the finger's own height, so that network delay makes the surface late but
cannot make the contact unstable. Only changes of the *model* are slowed; a rate limit inside the law would itself be
a source of oscillation.
"""

import math
from dataclasses import dataclass

from common.limits import FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S

VELOCITY_LAG_S = 0.008
"""Low-pass of the finger's speed: heights are quantised, 5 um in 2 ms are 2.5 mm/s."""


@dataclass(frozen=True, slots=True)
class ContactLaw:
    """Settings of the local contact.

    `stiffness_cap_n_m` keeps the loop stable for its own delay. At 500 Hz and 5 ms of loop delay, a finger with its
    exoskeleton (0.1 kg, 3 Ns/m, 400 N/m) stays stable to about 600 N/m.
    """

    stiffness_cap_n_m: float = 400.0
    damping_n_s_m: float = 1.0


class LocalContact:
    """One finger's contact: `step` gives the force to show, N, 0..10."""

    def __init__(self, law: ContactLaw | None = None):
        self._law = law or ContactLaw()
        self._t_s = math.nan
        self._z_m = 0.0
        self.approach_m_s = 0.0
        """Speed of the finger towards the surface, smoothed, m/s."""
        self._surface_m = 0.0
        self._stiffness = 0.0
        self._blend_n = 0.0

    def step(self, t_s: float, z_m: float, surface_m: float, stiffness_n_m: float) -> float:
        """Force at `t_s` for a finger at height `z_m`.

        Args:
            t_s: time, s.
            z_m: height of the finger, m, smaller is deeper.
            surface_m: height of the surface as the remote site last knew it, m.
            stiffness_n_m: its stiffness; 0 or less means that no surface is known.
        """
        dt_s = t_s - self._t_s
        self._t_s = t_s
        if 0.0 < dt_s <= 0.1:
            speed = (self._z_m - z_m) / dt_s
            self.approach_m_s += (speed - self.approach_m_s) * dt_s / (VELOCITY_LAG_S + dt_s)
        else:
            dt_s, self.approach_m_s = 0.0, 0.0
        self._z_m = z_m
        stiffness = min(max(0.0, stiffness_n_m), self._law.stiffness_cap_n_m)
        if stiffness != self._stiffness or surface_m != self._surface_m:
            before = self._force(z_m)
            self._stiffness, self._surface_m = stiffness, surface_m
            self._blend_n += before - self._force(z_m)
        blend = self._blend_n
        if blend > 0.0:  # the old model pushed harder: let go fast
            self._blend_n = max(0.0, blend - FORCE_RAMP_DOWN_N_S * dt_s)
        elif blend < 0.0:
            self._blend_n = min(0.0, blend + FORCE_RAMP_UP_N_S * dt_s)
        return min(FINGER_FORCE_N, max(0.0, self._force(z_m) + self._blend_n))

    def _force(self, z_m: float) -> float:
        """k d + b approach, never pulling."""
        depth = self._surface_m - z_m
        if depth <= 0.0 or self._stiffness == 0.0:
            return 0.0
        return max(0.0, self._stiffness * depth + self._law.damping_n_s_m * self.approach_m_s)
