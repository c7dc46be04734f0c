"""Computes the largest stiffness and damping of a virtual wall that a device can display passively.

A sampled wall holds each force for a period, so it pushes a leaving finger harder than an entering one. The device's
own damping must dissipate the energy that this generates:

    k (T/2 + t_d) + |B| <= b

Without delay this is the condition of Colgate & Schenkel (1994); with it, the linear law of Gil et al. (2009).
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SampledWall:
    """Properties of the device and its loop that bound the displayed walls.

    Attributes:
        damping_n_s_m: the device's own damping at a finger, without a hand, b, Ns/m.
        period_s: period of the control loop, T, s.
        delay_s: delay from measurement to force beyond the period, t_d, s.

    Raises:
        ValueError: a damping or delay is negative or not finite, or the period is not above 0.
    """

    damping_n_s_m: float
    period_s: float
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        given = (self.damping_n_s_m, self.period_s, self.delay_s)
        if not (all(0.0 <= value < math.inf for value in given) and self.period_s > 0.0):
            raise ValueError(
                "damping and delay must be finite and not negative and the period above 0, "
                f"not {self.damping_n_s_m} Ns/m, {self.delay_s} s and {self.period_s} s"
            )

    @property
    def stiffest_n_m(self) -> float:
        """Stiffest wall without damping, N/m."""
        return self.damping_n_s_m / (0.5 * self.period_s + self.delay_s)

    def damping_left_n_s_m(self, stiffness_n_m: float) -> float:
        """Return the largest damping of a wall of this stiffness, Ns/m; 0 if the stiffness uses the whole bound."""
        return max(0.0, self.damping_n_s_m - stiffness_n_m * (0.5 * self.period_s + self.delay_s))
