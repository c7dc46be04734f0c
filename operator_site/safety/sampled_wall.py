"""How stiff and how damped a wall a device can show without giving out energy of its own.

A wall that is measured and pushed in ticks holds each force too long, and pushes a finger that leaves it harder than it
pushed it coming in. What that makes, the device's own damping has to take:

    k (T/2 + t_d) + |B| <= b

Without delay this is the condition of Colgate & Schenkel (1994); with it, the linear law of Gil et al. (2009).
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SampledWall:
    """What of the device and its loop bounds the walls it can show.

    Attributes:
        damping_n_s_m: the device's own at a finger, without any hand, b.
        period_s: of the loop that measures and pushes, T.
        delay_s: from measuring to pushing, beyond the period itself, t_d.

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
        """Largest damping that a wall of this stiffness may have, Ns/m; 0 where the stiffness takes it all."""
        return max(0.0, self.damping_n_s_m - stiffness_n_m * (0.5 * self.period_s + self.delay_s))
