"""A passivity observer and controller for one port that pushes: the last guard against force that pumps energy.

The observer counts the work between a finger and what pushes it, from the force that was really commanded and the
height that was really measured (Hannaford & Ryu 2002). What the finger has put in makes an account, and what comes out
is taken from it. The controller lets no more force through than the stiffest wall that the device can show would have
at the energy that is left:

    F <= sqrt(2 k (account + PRODUCED_J))

Such a wall is itself passive, so the controller never chatters, adds no force, and lets every softer spring alone. It
has to be one that the loop can show as it runs now: a loop that holds its forces longer says so (`show`). A controller
that pays itself from the account ends at 0 N when the port has given out PRODUCED_J more than it was given. A debt is
forgiven while no force acts (FORGIVEN_W), and when outputs do not act at all.
"""

import math
from collections import deque
from itertools import islice

from common.limits import FORGIVEN_W, PRODUCED_J

FADE_S = 1.0
"""What was put in and cannot be stored in the present contact was lost in it: the account forgets it so fast."""
LONGEST_STEP_S = 0.1
FASTEST_M_S = 1.5
"""After longer without a measured height, or with a faster one than of a finger, it is not known what happened: the
account begins anew, but for what the port has given out too much."""
MOST_FORCES = 256
"""As many commands are remembered while heights are late."""
_SAME_S = 1e-6


class PassivityController:
    """Observer and controller of one finger's port: `observe` what was measured, `limit_n`, then `command` the force.

    Attributes:
        account_j: what the finger has put in and may come back, J; negative: so much more has come out.
        most_produced_j: the most that had come out beyond what was put in, since it was last set to 0.
    """

    __slots__ = (
        "_damping_n_s_m",
        "_delay_s",
        "_forces",
        "_kept_j",
        "_t_s",
        "_top_m",
        "_twice_n_m",
        "_z_m",
        "account_j",
        "most_produced_j",
    )

    def __init__(self, stiffest_n_m: float, kept_j: float, *, damping_n_s_m: float = 0.0, delay_s: float = 0.0) -> None:
        """A port that nothing has gone through.

        Args:
            stiffest_n_m: stiffest wall that the device can show passively, k.
            kept_j: of what a contact has lost, so much may come back; that a spring gives back what it holds is beside
                that.
            damping_n_s_m: the device's own, between the force and the finger: it takes some of what the force does.
            delay_s: from measuring a height to the force that answers it, beyond the loop's period.
        """
        self.show(stiffest_n_m)
        self._kept_j = kept_j
        self._damping_n_s_m, self._delay_s = damping_n_s_m, delay_s
        self._forces: deque[tuple[float, float]] = deque(((-math.inf, 0.0),), maxlen=MOST_FORCES)
        """When each force began, and the force; the first is the oldest that still counts."""
        self._t_s = self._z_m = self._top_m = math.nan
        self.account_j = 0.0
        self.most_produced_j = 0.0

    @property
    def produced_j(self) -> float:
        """What has come out beyond what was put in, J."""
        return max(0.0, -self.account_j)

    def observe(self, t_s: float, z_m: float) -> None:
        """Count the work since the last measured height.

        Args:
            t_s: when the height was measured, s; the same time again is the same sample again.
            z_m: the height, m, in the direction of the force; not finite: not known.
        """
        dt_s, rise_m = t_s - self._t_s, z_m - self._z_m
        if 0.0 <= dt_s < _SAME_S:
            return
        # Neither holds for what is not a number.
        if not _SAME_S <= dt_s <= LONGEST_STEP_S or not abs(rise_m) <= FASTEST_M_S * dt_s:
            self.account_j = min(0.0, self.account_j)  # what it owes, it still owes
            self._top_m = z_m
        else:
            taken_j = self._damping_n_s_m * rise_m * rise_m / dt_s  # the least that the device's damping took
            force_n = self._forces[-1][1]
            account_j = self.account_j + (taken_j - self._mean_n(dt_s) * rise_m)
            # A force that falls as the finger rises gives back at most itself times the way up; what is beyond is lost.
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
        """From now on this is the stiffest wall that the device, and the loop as it runs, can show passively, N/m."""
        self._twice_n_m = 2.0 * stiffest_n_m

    def rest(self) -> None:
        """Nothing may come out now, whatever the account says: what does later owes nothing of before."""
        self.account_j = max(0.0, self.account_j)

    def limit_n(self) -> float:
        """The largest force that the account can pay for, N."""
        return math.sqrt(self._twice_n_m * max(0.0, self.account_j + PRODUCED_J))

    def command(self, t_s: float, force_n: float) -> None:
        """Take the force that is commanded at `t_s`, N, and held until the next."""
        forces = self._forces
        last_s, last_n = forces[-1]
        if last_n == 0.0 == force_n and t_s > last_s:
            return  # it has been 0 since then
        while forces and not t_s > forces[-1][0]:  # a clock that was set back: what comes now follows all the others
            forces.pop()
        forces.append((t_s, force_n))

    def _mean_n(self, dt_s: float) -> float:
        """Mean of the forces that acted between the last height and one `dt_s` later."""
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
