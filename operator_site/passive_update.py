"""Entering a new model into a finger's contact so that the model can never push the finger with energy of its own.

The contact is a spring, F = k d. What the finger has put into it and the spring does not hold has been dissipated: it
is counted, at the force that was held over each interval, as a passivity observer does (Hannaford & Ryu 2002). A new
surface or stiffness may raise the spring's energy only out of that account. So late, noisy or wrong models leave the
contact passive, and a finger inside the surface is pressed outwards no further than it pressed inwards before.

The spring itself is passive when its stiffness is below the bound of the sampled wall (Colgate & Schenkel 1994).
"""

import math

from common.limits import FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S

ACCOUNT_J = 0.005
"""No more is kept to be given back: 2 N over 2.5 mm, a breath."""
LONGEST_STEP_S = 0.1


def passive_stiffness_n_m(
    device_damping_n_s_m: float, period_s: float, loop_delay_s: float = 0.0, law_damping_n_s_m: float = 0.0
) -> float:
    """Stiffest wall that a device can show passively, N/m: (b - |B|) / (T/2 + t_d), 0 when there is none.

    Without delay this is K <= 2 (b - |B|) / T (Colgate & Schenkel 1994); with it the linear law of Gil et al. 2009.

    Args:
        device_damping_n_s_m: the device's own, b.
        period_s: of the loop that measures and pushes, T.
        loop_delay_s: from measuring to pushing, beyond the period itself, t_d.
        law_damping_n_s_m: damping that the contact law adds, B.

    Raises:
        ValueError: a damping, period or delay is negative or not finite, or the period is 0.
    """
    given = (device_damping_n_s_m, period_s, loop_delay_s)
    if not (all(0.0 <= value < math.inf for value in given) and period_s > 0.0 and math.isfinite(law_damping_n_s_m)):
        raise ValueError(
            "dampings and delay must be finite and not negative and the period above 0, "
            f"not {device_damping_n_s_m}, {law_damping_n_s_m}, {loop_delay_s} and {period_s}"
        )
    return max(0.0, device_damping_n_s_m - abs(law_damping_n_s_m)) / (0.5 * period_s + loop_delay_s)


class PassiveContact:
    """One finger's contact with a model that may change at any time: `step` gives the force to show, N, 0..10.

    Attributes:
        surface_m: height of the surface that is shown, m; it may lag behind the model's.
        stiffness_n_m: stiffness that is shown; 0 where nothing is.
        account_j: what the finger put in and the spring does not hold, J: all that updates may spend.
    """

    __slots__ = ("_cap_n_m", "_damping_n_s_m", "_force_n", "_t_s", "_z_m", "account_j", "stiffness_n_m", "surface_m")

    def __init__(self, stiffness_cap_n_m: float, device_damping_n_s_m: float = 0.0) -> None:
        """A contact no stiffer than the cap; damping that the device surely has is counted as dissipated."""
        self._cap_n_m = stiffness_cap_n_m
        self._damping_n_s_m = device_damping_n_s_m
        self._t_s = self._z_m = math.nan
        self._force_n = 0.0
        self.account_j = 0.0
        self.surface_m = self.stiffness_n_m = 0.0

    def step(self, t_s: float, z_m: float, surface_m: float, stiffness_n_m: float) -> float:
        """Force at `t_s` for a finger at height `z_m`; it is held until the next step.

        Args:
            t_s: time, s.
            z_m: height of the finger, m, smaller is deeper.
            surface_m: height of the surface as the remote site last knew it, m.
            stiffness_n_m: its stiffness; 0 or less means that no surface is known.
        """
        dt_s = t_s - self._t_s
        if not 0.0 < dt_s <= LONGEST_STEP_S or not math.isfinite(z_m):
            dt_s = 0.0
            self.stiffness_n_m = self.account_j = 0.0  # what happened meanwhile is not known: begin anew
        else:
            self._observe(dt_s, z_m)
        self._t_s, self._z_m = t_s, z_m
        known = stiffness_n_m > 0.0 and math.isfinite(surface_m) and math.isfinite(z_m)
        self._enter(dt_s, surface_m if known else -math.inf, min(stiffness_n_m, self._cap_n_m) if known else 0.0)
        self._force_n = min(FINGER_FORCE_N, self.stiffness_n_m * self._depth_m())
        return self._force_n

    def _depth_m(self) -> float:
        return max(0.0, self.surface_m - self._z_m) if self.stiffness_n_m > 0.0 else 0.0

    def _stored_j(self) -> float:
        """Energy of the spring that can come back, N m: above the force limit it is a constant force."""
        force_n = self.stiffness_n_m * self._depth_m()
        if force_n <= FINGER_FORCE_N:
            return 0.5 * force_n * self._depth_m()
        return FINGER_FORCE_N * (self._depth_m() - 0.5 * FINGER_FORCE_N / self.stiffness_n_m)

    def _observe(self, dt_s: float, z_m: float) -> None:
        """Count what the finger put in since the last step, less what the spring stored of it."""
        descent_m, before_j = self._z_m - z_m, self._stored_j()
        self._z_m = z_m
        dissipated_j = self._damping_n_s_m * descent_m * descent_m / dt_s  # the least that the device's damping took
        self.account_j += self._force_n * descent_m + dissipated_j + before_j - self._stored_j()

    def _enter(self, dt_s: float, surface_m: float, stiffness_n_m: float) -> None:
        """Take as much of the model as costs no energy, or as the account pays."""
        depth_m = self._depth_m()
        if depth_m == 0.0:
            self.stiffness_n_m = stiffness_n_m
            self.surface_m = min(surface_m, self._z_m)  # up to the finger, not beyond it: that costs nothing
        before_j, force_n = self._stored_j(), self.stiffness_n_m * depth_m
        if depth_m > 0.0 and stiffness_n_m > 0.0:
            # As hard as before at most, and with no more energy than before.
            ratio = self.stiffness_n_m / stiffness_n_m
            depth_m *= min(ratio, math.sqrt(ratio))
            self.stiffness_n_m = stiffness_n_m
            self.surface_m = self._z_m + depth_m
        self.account_j = min(ACCOUNT_J, self.account_j + before_j - self._stored_j())
        wanted_m = max(0.0, surface_m - self._z_m)
        if self.stiffness_n_m <= 0.0 or wanted_m == depth_m:
            return
        before_j = self._stored_j()
        if wanted_m < depth_m:
            lowest_n = force_n - FORCE_RAMP_DOWN_N_S * dt_s
            depth_m = min(depth_m, max(wanted_m, lowest_n / self.stiffness_n_m))
        else:
            payable_m = math.sqrt(depth_m * depth_m + 2.0 * max(0.0, self.account_j) / self.stiffness_n_m)
            depth_m = min(wanted_m, payable_m, depth_m + FORCE_RAMP_UP_N_S * dt_s / self.stiffness_n_m)
        self.surface_m = self._z_m + max(0.0, depth_m)
        self.account_j = min(ACCOUNT_J, self.account_j + before_j - self._stored_j())
