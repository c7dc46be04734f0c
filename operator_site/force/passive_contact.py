"""Entering a new model into a finger's contact so that the model can never push the finger with energy of its own.

The contact is a spring, F = k d. What the finger has put into it and the spring does not hold has been dissipated: it
is counted, at the force that was held over each interval, as a passivity observer does (Hannaford & Ryu 2002). A new
surface or stiffness may raise the spring's energy only out of that account, which may be overdrawn by LENT_J. So late,
noisy or wrong models leave the contact passive, and a finger inside the surface is pressed outwards no further than it
pressed inwards before. Where the force came later than the finger, as when a session is engaged, the surface is near
the finger; the true one is taken along when it lifts, or as fast as it pays. What is owed is forgiven while no force
acts (FORGIVEN_W).

Spring and damper themselves are passive within the bounds of the sampled wall, and are never more.
"""

import math

from common.limits import ACCOUNT_J, FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S, FORGIVEN_W
from operator_site.safety.sampled_wall import SampledWall

LENT_J = 0.35e-3
"""So much a surface may borrow: a contact that begins around the finger is felt at once, with 0.53 N on 400 N/m. It is
lent once, until the finger has paid it back, or it is forgiven: no model can pump it."""
RESTED_J = 0.5e-3
"""So much is in the account at least when outputs begin to act, which no hand and no model makes them do: a press that
was interrupted is felt again without being lifted, 0.8 N with the half of it at least."""
LONGEST_STEP_S = 0.1


class PassiveContact:
    """One finger's contact with a model that may change at any time: `step` gives the force to show, N, 0..10.

    Attributes:
        force_n: force of the last step that was let through to the finger, N.
        capped: whether the model's surface is stiffer than the device may show.
        surface_m: height of the surface that is shown, m; it may lag behind the model's.
        stiffness_n_m: stiffness that is shown; 0 where nothing is.
        account_j: what the finger put in and the spring does not hold, J; not below -LENT_J by updates.
    """

    __slots__ = (
        "_held_j",
        "_stiffest_n_m",
        "_t_s",
        "_wall",
        "_z_m",
        "account_j",
        "capped",
        "force_n",
        "stiffness_n_m",
        "surface_m",
    )

    def __init__(self, wall: SampledWall) -> None:
        """A contact within what the device can show; its own damping, which it surely has, counts as dissipated."""
        self.show(wall)
        self._t_s = self._z_m = math.nan
        self.force_n = self._held_j = 0.0
        self.account_j = 0.0
        self.surface_m = self.stiffness_n_m = 0.0
        self.capped = False

    def show(self, wall: SampledWall) -> None:
        """From now on keep within this wall."""
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
        """Force at `t_s` for a finger at height `z_m`; it is held until the next step.

        Args:
            t_s: time, s.
            z_m: height of the finger, m, smaller is deeper.
            surface_m: height of the surface as the remote site last knew it, m.
            stiffness_n_m: its stiffness; 0 or less means that no surface is known.
            damping_n_s_m: its damping; shown as far as the stiffness leaves room for it.
            approach_m_s: speed of the finger into the surface, smoothed.
        """
        dt_s = t_s - self._t_s
        self._t_s = t_s
        if 0.0 <= dt_s <= LONGEST_STEP_S and math.isfinite(z_m):
            depth_m = self._observe(dt_s, z_m)
        else:  # what happened meanwhile is not known: begin anew
            dt_s = depth_m = self._held_j = self.stiffness_n_m = self.account_j = 0.0
            self._z_m = z_m
        # Neither holds for what is not a number.
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
        """Outputs do not act: a contact that is there when they do begins with RESTED_J."""
        self.account_j = max(self.account_j, RESTED_J)

    def let_through(self, force_n: float) -> None:
        """Only this much of the force of the last step was let through to the finger, N.

        What does not push takes nothing from the finger: the surface sinks until its spring holds no more than that.
        What it held beyond is in the account again.
        """
        lacking_n = self.force_n - force_n
        if lacking_n > 0.0:
            self.force_n = force_n
            depth_m = max(0.0, self.surface_m - self._z_m - lacking_n / self.stiffness_n_m)
            self.surface_m = self._z_m + depth_m
            self._hold(depth_m)

    def _observe(self, dt_s: float, z_m: float) -> float:
        """Count what the finger put in since the last step, less what the spring stored of it; the depth now, m."""
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
            put_in_j += self._wall.damping_n_s_m * descent_m * descent_m / dt_s  # the least that the device took
        account_j = self.account_j + put_in_j + before_j - held_j
        if account_j < 0.0 and force_n == 0.0:
            account_j = min(0.0, account_j + FORGIVEN_W * dt_s)
        self._held_j = held_j
        self.account_j = account_j if account_j < ACCOUNT_J else ACCOUNT_J
        return depth_m

    def _enter(self, dt_s: float, depth_m: float, surface_m: float, stiffness_n_m: float) -> float:
        """Take as much of the model as costs no energy, or as the account pays; the depth that is shown, m.

        Args:
            dt_s: since the last step, s.
            depth_m: of the finger in the surface that is shown, m.
            surface_m: height of the model's surface, m; -inf where nothing is known.
            stiffness_n_m: of the model; 0 where nothing is known.
        """
        force_n, wanted_m = self.stiffness_n_m * depth_m, max(0.0, surface_m - self._z_m)
        if depth_m == 0.0:
            self.stiffness_n_m = stiffness_n_m  # that costs nothing
        elif 0.0 < stiffness_n_m != self.stiffness_n_m:
            # As hard as before at most, and with no more energy than before.
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
        # A finger above the surface meets it where it is.
        self.surface_m = self._z_m + depth_m if wanted_m > 0.0 or depth_m > 0.0 else surface_m
        return depth_m

    def _hold(self, depth_m: float) -> None:
        """Let the spring hold this depth; what it held before comes into the account, what it takes is paid from it."""
        before_j, self._held_j = self._held_j, _stored_j(self.stiffness_n_m, depth_m)
        self.account_j = min(ACCOUNT_J, self.account_j + before_j - self._held_j)


def _stored_j(stiffness_n_m: float, depth_m: float) -> float:
    """Energy of the spring that can come back, J: above the force limit it is a constant force."""
    force_n = stiffness_n_m * depth_m
    if force_n <= FINGER_FORCE_N:
        return 0.5 * force_n * depth_m
    return FINGER_FORCE_N * (depth_m - 0.5 * FINGER_FORCE_N / stiffness_n_m)
