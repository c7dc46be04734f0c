"""Impulses J(t) of a patterned surface (Kron & Schmidt 2003, section 3.1), one for each groove that is crossed.

One by one as far as a motor and a finger can keep them apart; where they come faster, as what is left of them then: a
higher speed of the same mean.
"""

import math

from common.limits import MOTOR_MAX_RPM
from operator_site.vibration.motor_drive import RPM_TO_RAD_S

DECAY_PER_S = 60.0
"""Of impulses where the surface model gives none."""
FOLD_ABOVE_HZ = 20.0
APART_BELOW_HZ = 15.0
"""Grooves that are crossed faster than the first are folded into the bias speed, until slower than the second."""
OVER_S = 2.0 / APART_BELOW_HZ
"""Without another groove for so long the pattern has ended."""
_NEVER_NS = -(10**18)


class Grooves:
    """The pattern under one finger.

    Attributes:
        rad_s: what it adds to the motor's speed now.
        folded: whether that is a mean.
    """

    def __init__(self) -> None:
        self.rad_s = 0.0
        self.folded = False
        self._t_s = -math.inf
        self._came_s = -math.inf
        self._crossed_ns = _NEVER_NS
        self._gap_s = math.inf

    def end(self) -> None:
        """No longer stroking over it."""
        self.rad_s, self.folded, self._crossed_ns, self._gap_s = 0.0, False, _NEVER_NS, math.inf

    def step(self, t_s: float, decay_per_s: float) -> None:
        """Let impulses decay until `t_s`, at their surface's rate or, for 0, the usual one."""
        before_s, self._t_s = self._t_s, t_s
        if self.folded and t_s - self._came_s > OVER_S:
            self.end()
        if self.rad_s and not self.folded:
            # A sum of equal exponentials decays as one: J(t) needs a single number.
            self.rad_s *= math.exp(-(decay_per_s or DECAY_PER_S) * max(0.0, t_s - before_s))

    def cross(self, amplitude_rad_s: float, time_ns: int, decay_per_s: float) -> None:
        """A groove was crossed.

        Args:
            amplitude_rad_s: of its impulse.
            time_ns: when, on the clock of where it happened: grooves may arrive in heaps.
            decay_per_s: of its impulse; 0 for the usual one.
        """
        gap_s, self._crossed_ns = 1e-9 * (time_ns - self._crossed_ns), time_ns
        known = 0.0 < gap_s < OVER_S
        # The mean of two gaps: one groove that is a little early makes no train of them.
        rate_hz = 2.0 / (gap_s + self._gap_s) if known else 0.0
        self._gap_s = gap_s if known else math.inf
        self._came_s = self._t_s
        self.folded = rate_hz > (APART_BELOW_HZ if self.folded else FOLD_ABOVE_HZ)
        amplitude = max(0.0, amplitude_rad_s)
        mean = amplitude * rate_hz / (decay_per_s or DECAY_PER_S)
        self.rad_s = min(MOTOR_MAX_RPM * RPM_TO_RAD_S, mean if self.folded else self.rad_s + amplitude)
