"""Computes the impulses J(t) of a patterned surface (Kron & Schmidt 2003, section 3.1), one for each crossed groove.

Impulses are played one by one as far as motor and finger can resolve them. Faster ones are replaced by a constant
speed with the same mean.
"""

import math

from common.limits import MOTOR_MAX_RPM
from operator_site.vibration.motor_drive import RPM_TO_RAD_S

DECAY_PER_S = 60.0
"""Decay rate of impulses without one in the surface model, 1/s."""
FOLD_ABOVE_HZ = 20.0
"""Rate of grooves above which they are folded into their mean speed, Hz."""
APART_BELOW_HZ = 15.0
"""Rate of grooves below which folded ones are played one by one again, Hz."""
OVER_S = 2.0 / APART_BELOW_HZ
"""Time without a groove after which the pattern has ended, s."""
_NEVER_NS = -(10**18)


class Grooves:
    """The pattern under one finger.

    Attributes:
        rad_s: present addition to the motor's speed, rad/s.
        folded: whether the addition is a mean.
    """

    def __init__(self) -> None:
        self.rad_s = 0.0
        self.folded = False
        self._t_s = -math.inf
        self._came_s = -math.inf
        self._crossed_ns = _NEVER_NS
        self._gap_s = math.inf

    def end(self) -> None:
        """End the pattern, because the finger no longer strokes."""
        self.rad_s, self.folded, self._crossed_ns, self._gap_s = 0.0, False, _NEVER_NS, math.inf

    def step(self, t_s: float, decay_per_s: float) -> None:
        """Let impulses decay until `t_s` at their surface's rate, or at DECAY_PER_S if that is 0."""
        before_s, self._t_s = self._t_s, t_s
        if self.folded and t_s - self._came_s > OVER_S:
            self.end()
        if self.rad_s and not self.folded:
            # A sum of equal exponentials decays as one: J(t) needs a single number.
            self.rad_s *= math.exp(-(decay_per_s or DECAY_PER_S) * max(0.0, t_s - before_s))

    def cross(self, amplitude_rad_s: float, time_ns: int, decay_per_s: float) -> None:
        """Add a crossed groove.

        Args:
            amplitude_rad_s: amplitude of its impulse, rad/s.
            time_ns: time of the crossing on the clock of its site, ns; grooves may arrive in bursts.
            decay_per_s: decay rate of its impulse, 1/s; 0 for DECAY_PER_S.
        """
        gap_s, self._crossed_ns = 1e-9 * (time_ns - self._crossed_ns), time_ns
        known = 0.0 < gap_s < OVER_S
        # Average two gaps, so that one early groove does not count as a fast train.
        rate_hz = 2.0 / (gap_s + self._gap_s) if known else 0.0
        self._gap_s = gap_s if known else math.inf
        self._came_s = self._t_s
        self.folded = rate_hz > (APART_BELOW_HZ if self.folded else FOLD_ABOVE_HZ)
        amplitude = max(0.0, amplitude_rad_s)
        mean = amplitude * rate_hz / (decay_per_s or DECAY_PER_S)
        self.rad_s = min(MOTOR_MAX_RPM * RPM_TO_RAD_S, mean if self.folded else self.rad_s + amplitude)
