"""Implements a passivity observer and controller for one force port, the last guard against generated energy.

The observer counts the work between a finger and its actuator, from the commanded force and the measured height
(Hannaford & Ryu 2002). The finger's work is credited to an account, and returned energy is debited. The controller
limits the force to that of the stiffest wall that the device can display, at the remaining energy:

    F <= sqrt(2 k (account + PRODUCED_J))

Such a wall is itself passive, so the controller does not chatter, adds no force, and leaves every softer spring
unchanged. The wall must be one that the loop can display at its present period, which `show` sets. The limit reaches
0 N when the port has released PRODUCED_J more than it received. A debt is forgiven at FORGIVEN_W while no force acts,
and completely while outputs do not act.
"""

import math
from collections import deque
from itertools import islice

from common.limits import FORGIVEN_W, PRODUCED_J

FADE_S = 1.0
"""Time constant with which the account loses energy that the present contact cannot store, s."""
LONGEST_STEP_S = 0.1
"""Longest gap between two measured heights, s; after a longer one the account restarts at 0, but keeps a debt."""
FASTEST_M_S = 1.5
"""Largest speed of a finger, m/s; after a faster change of height the account restarts at 0, but keeps a debt."""
MOST_FORCES = 256
"""Maximum number of commands that are remembered while heights are late."""
_SAME_S = 1e-6
"""Largest time difference of two heights that are one sample, s."""


class PassivityController:
    """Observer and controller of one finger's port: call `observe`, `limit_n`, then `command` in each tick.

    Attributes:
        account_j: energy from the finger that may return to it, J; a negative value is generated energy.
        most_produced_j: largest generated energy since this attribute was last set to 0, J.
    """

    def __init__(self, stiffest_n_m: float, kept_j: float, *, damping_n_s_m: float = 0.0, delay_s: float = 0.0) -> None:
        """Begin with an empty account.

        Args:
            stiffest_n_m: stiffest wall that the device can display passively, k, N/m.
            kept_j: dissipated energy of a contact that may return, J, in addition to the energy of its spring.
            damping_n_s_m: the device's own damping between the force and the finger, Ns/m; it dissipates some work.
            delay_s: delay from measuring a height to the answering force, s, beyond the loop's period.
        """
        self.show(stiffest_n_m)
        self._kept_j = kept_j
        self._damping_n_s_m, self._delay_s = damping_n_s_m, delay_s
        self._forces: deque[tuple[float, float]] = deque(((-math.inf, 0.0),), maxlen=MOST_FORCES)
        """Begin, s, and value, N, of each force; the first is the oldest one still acting on a counted interval."""
        self._t_s = self._z_m = self._top_m = math.nan
        self.account_j = 0.0
        self.most_produced_j = 0.0

    @property
    def produced_j(self) -> float:
        """Generated energy, J: released beyond what was put in."""
        return max(0.0, -self.account_j)

    def observe(self, t_s: float, z_m: float) -> None:
        """Count the work since the last measured height.

        Args:
            t_s: time of the measured height, s; a repeated time is the same sample.
            z_m: height in the direction of the force, m; not finite if unknown.
        """
        dt_s, rise_m = t_s - self._t_s, z_m - self._z_m
        if 0.0 <= dt_s < _SAME_S:
            return
        # Both conditions hold for NaN, as their comparisons are false.
        if not _SAME_S <= dt_s <= LONGEST_STEP_S or not abs(rise_m) <= FASTEST_M_S * dt_s:
            self.account_j = min(0.0, self.account_j)  # a debt remains
            self._top_m = z_m
        else:
            taken_j = self._damping_n_s_m * rise_m * rise_m / dt_s  # least dissipation by the device's damping
            force_n = self._forces[-1][1]
            account_j = self.account_j + (taken_j - self._mean_n(dt_s) * rise_m)
            # A force that falls as the finger rises returns at most its value times the rise; the excess is lost.
            if not (force_n > 0.0 and self._top_m > z_m):
                self._top_m = z_m
            beyond_j = account_j - self._kept_j - force_n * (self._top_m - z_m)
            if beyond_j > 0.0:
                account_j -= beyond_j * (dt_s / FADE_S)
            if account_j < 0.0 and force_n == 0.0:
                account_j = min(0.0, account_j + FORGIVEN_W * dt_s)
            self.account_j = account_j
        self.most_produced_j = max(self.most_produced_j, -self.account_j)
        self._t_s, self._z_m = t_s, z_m

    def show(self, stiffest_n_m: float) -> None:
        """Set the stiffest wall that device and loop can display passively at present, N/m."""
        self._twice_n_m = 2.0 * stiffest_n_m

    def rest(self) -> None:
        """Forgive the debt, while outputs do not act."""
        self.account_j = max(0.0, self.account_j)

    def limit_n(self) -> float:
        """Return the largest force that the account permits, N."""
        return math.sqrt(self._twice_n_m * max(0.0, self.account_j + PRODUCED_J))

    def command(self, t_s: float, force_n: float) -> None:
        """Note the force that is commanded at `t_s`, N, and held until the next command."""
        forces = self._forces
        last_s, last_n = forces[-1]
        if last_n == 0.0 == force_n and t_s > last_s:
            return  # still 0
        while forces and not t_s > forces[-1][0]:  # the clock was set back: drop later commands
            forces.pop()
        forces.append((t_s, force_n))

    def _mean_n(self, dt_s: float) -> float:
        """Return the mean force, N, between the last height and one `dt_s` later, shifted by the delay."""
        forces = self._forces
        begin_s = self._t_s - self._delay_s
        end_s = begin_s + dt_s
        while len(forces) > 1 and forces[1][0] <= begin_s:
            forces.popleft()
        if len(forces) == 1 and forces[0][1] == 0.0:
            return 0.0
        impulse, since_s, acting_n = 0.0, begin_s, forces[0][1]
        for began_s, force_n in islice(forces, 1, None):
            if began_s >= end_s:
                break
            impulse += acting_n * (began_s - since_s)
            since_s, acting_n = began_s, force_n
        return (impulse + acting_n * (end_s - since_s)) / dt_s
