"""Updates the contact model of one finger passively, so that a new model cannot push the finger with its own energy.

The contact is a spring, F = k d. Energy that the finger has put in and the spring does not store was dissipated. An
account counts it at the force held over each interval, as a passivity observer does (Hannaford & Ryu 2002). A new
surface or stiffness may raise the spring's energy only from this account, which may be overdrawn by LENT_J. Late, noisy
or wrong models therefore leave the contact passive. A finger inside the surface is pressed outwards no further than it
pressed inwards before.

If the finger is already inside when the force begins, as on engaging, the displayed surface starts near the finger. It
approaches the true surface when the finger lifts, or as fast as the account pays. The debt is forgiven at FORGIVEN_W
while no force acts.

Spring and damper never exceed the bounds of the sampled wall, within which they are passive.
"""

import math

from common.limits import ACCOUNT_J, FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S, FORGIVEN_W
from operator_site.safety.sampled_wall import SampledWall

LENT_J = 0.35e-3
"""Largest debt of the account, J.

A contact that begins around the finger acts at once, with 0.53 N at 400 N/m. The debt must be repaid by the finger
or forgiven before it is lent again, so that no model can pump energy.
"""
RESTED_J = 0.5e-3
"""Smallest balance of the account when outputs begin to act, J.

An interrupted press of 0.8 N is felt again with at least half its force, without lifting the finger. Neither a hand nor
a model can make the outputs begin to act.
"""
LONGEST_STEP_S = 0.1
"""Longest step over which energy is counted, s; after a longer one the account starts again at 0."""


class PassiveContact:
    """One finger's contact with a model that may change at any time; `step` returns the force to display, N, 0..10.

    Attributes:
        force_n: force of the last step that was let through to the finger, N.
        capped: whether the model's surface is stiffer than the device may display.
        surface_m: height of the displayed surface, m; it may lag behind the model's.
        stiffness_n_m: displayed stiffness, N/m; 0 without a surface.
        account_j: energy that the finger put in and the spring does not store, J; updates keep it at -LENT_J or above.
    """

    def __init__(self, wall: SampledWall) -> None:
        """Begin without a surface, within the bounds of `wall`; the device's own damping counts as dissipation."""
        self.show(wall)
        self._t_s = self._z_m = math.nan
        self.force_n = self._held_j = 0.0
        self.account_j = 0.0
        self.surface_m = self.stiffness_n_m = 0.0
        self.capped = False

    def show(self, wall: SampledWall) -> None:
        """Set the bound of the displayed walls."""
        self._wall, self._stiffest_n_m = wall, wall.stiffest_n_m

    def step(
        self,
        t_s: float,
        z_m: float,
        surface_m: float,
        stiffness_n_m: float,
        damping_n_s_m: float = 0.0,
        approach_m_s: float = 0.0,
    ) -> float:
        """Return the force at `t_s` for a finger at height `z_m`, N; it is held until the next step.

        Args:
            t_s: time, s.
            z_m: height of the finger, m, smaller is deeper.
            surface_m: height of the surface by the remote site's newest estimate, m.
            stiffness_n_m: its stiffness, N/m; 0 or less means that no surface is known.
            damping_n_s_m: its damping, Ns/m; limited to what the stiffness leaves of the wall's bound.
            approach_m_s: smoothed speed of the finger into the surface, m/s.
        """
        dt_s = t_s - self._t_s
        self._t_s = t_s
        if 0.0 <= dt_s <= LONGEST_STEP_S and math.isfinite(z_m):
            depth_m = self._observe(dt_s, z_m)
        else:  # the energy exchanged meanwhile is unknown: restart
            dt_s = depth_m = self._held_j = self.stiffness_n_m = self.account_j = 0.0
            self._z_m = z_m
        # Both conditions are false for NaN.
        known = stiffness_n_m > 0.0 and abs(surface_m - z_m) < math.inf
        self.capped = known and stiffness_n_m > self._stiffest_n_m
        if not known:
            surface_m, stiffness_n_m = -math.inf, 0.0
        elif self.capped:
            stiffness_n_m = self._stiffest_n_m
        if depth_m == 0.0 and not surface_m > z_m:  # a finger above the surface: any model costs nothing
            self.surface_m, self.stiffness_n_m, self.force_n = surface_m, stiffness_n_m, 0.0
            return 0.0
        depth_m = self._enter(dt_s, depth_m, surface_m, stiffness_n_m)
        if depth_m == 0.0:
            self.force_n = 0.0
            return 0.0
        damper_n_s_m = min(damping_n_s_m, self._wall.damping_left_n_s_m(self.stiffness_n_m)) if damping_n_s_m else 0.0
        self.force_n = min(FINGER_FORCE_N, max(0.0, self.stiffness_n_m * depth_m + damper_n_s_m * approach_m_s))
        return self.force_n

    def rest(self) -> None:
        """Raise the account to RESTED_J, while outputs do not act."""
        self.account_j = max(self.account_j, RESTED_J)

    def let_through(self, force_n: float) -> None:
        """Reduce the force of the last step to what was let through to the finger, N.

        A force that was not applied did no work on the finger. The surface sinks until its spring matches the applied
        force, and the energy released by the spring returns to the account.
        """
        lacking_n = self.force_n - force_n
        if lacking_n > 0.0:
            self.force_n = force_n
            depth_m = max(0.0, self.surface_m - self._z_m - lacking_n / self.stiffness_n_m)
            self.surface_m = self._z_m + depth_m
            self._hold(depth_m)

    def _observe(self, dt_s: float, z_m: float) -> float:
        """Count the finger's work since the last step, less the energy stored in the spring; return the depth, m."""
        descent_m, force_n = self._z_m - z_m, self.force_n
        self._z_m = z_m
        depth_m, held_j, before_j = 0.0, 0.0, self._held_j
        if self.stiffness_n_m > 0.0 and self.surface_m > z_m:
            depth_m = self.surface_m - z_m
            held_j = _stored_j(self.stiffness_n_m, depth_m)
        elif self.account_j == ACCOUNT_J and force_n == before_j == 0.0:
            return 0.0  # a full account stays full
        put_in_j = force_n * descent_m
        if dt_s > 0.0:
            put_in_j += self._wall.damping_n_s_m * descent_m * descent_m / dt_s  # least dissipation of the device
        account_j = self.account_j + put_in_j + before_j - held_j
        if account_j < 0.0 and force_n == 0.0:
            account_j = min(0.0, account_j + FORGIVEN_W * dt_s)
        self._held_j = held_j
        self.account_j = account_j if account_j < ACCOUNT_J else ACCOUNT_J
        return depth_m

    def _enter(self, dt_s: float, depth_m: float, surface_m: float, stiffness_n_m: float) -> float:
        """Adopt as much of the model as costs no energy or as the account pays; return the displayed depth, m.

        Args:
            dt_s: time since the last step, s.
            depth_m: depth of the finger in the displayed surface, m.
            surface_m: height of the model's surface, m; -inf if unknown.
            stiffness_n_m: stiffness of the model, N/m; 0 if unknown.
        """
        force_n, wanted_m = self.stiffness_n_m * depth_m, max(0.0, surface_m - self._z_m)
        if depth_m == 0.0:
            self.stiffness_n_m = stiffness_n_m  # costs no energy
        elif 0.0 < stiffness_n_m != self.stiffness_n_m:
            # Neither force nor energy may exceed those before the change.
            ratio = self.stiffness_n_m / stiffness_n_m
            depth_m *= min(ratio, math.sqrt(ratio))
            self.stiffness_n_m = stiffness_n_m
            self._hold(depth_m)
        if self.stiffness_n_m > 0.0 and wanted_m != depth_m:
            if wanted_m < depth_m:
                lowest_n = force_n - FORCE_RAMP_DOWN_N_S * dt_s
                depth_m = min(depth_m, max(wanted_m, lowest_n / self.stiffness_n_m))
            else:
                payable_m = math.sqrt(depth_m * depth_m + 2.0 * max(0.0, self.account_j + LENT_J) / self.stiffness_n_m)
                depth_m = min(wanted_m, payable_m, depth_m + FORCE_RAMP_UP_N_S * dt_s / self.stiffness_n_m)
            self._hold(depth_m)
        # For a finger above the surface, the model's height is displayed unchanged.
        self.surface_m = self._z_m + depth_m if wanted_m > 0.0 or depth_m > 0.0 else surface_m
        return depth_m

    def _hold(self, depth_m: float) -> None:
        """Set the depth of the spring and charge the change of its energy to the account."""
        before_j, self._held_j = self._held_j, _stored_j(self.stiffness_n_m, depth_m)
        self.account_j = min(ACCOUNT_J, self.account_j + before_j - self._held_j)


def _stored_j(stiffness_n_m: float, depth_m: float) -> float:
    """Return the recoverable energy of the spring, J; above the force limit the force is constant."""
    force_n = stiffness_n_m * depth_m
    if force_n <= FINGER_FORCE_N:
        return 0.5 * force_n * depth_m
    return FINGER_FORCE_N * (depth_m - 0.5 * FINGER_FORCE_N / stiffness_n_m)
