"""What limits one finger's force: range, the energy that may come out, ramps. And does it swing?"""

import math

from common.faults.fault import Fault
from common.limits import ACCOUNT_J, FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S, FORCE_SAFE_S, GAP_S
from common.safety.oscillation_detector import OscillationDetector
from operator_site.safety.passivity_controller import PassivityController
from operator_site.safety.sampled_wall import SampledWall

FORCE_MARGIN_S = 0.010
"""Forces reach zero this much before the deadline: time for the tick that sends it and the bus."""
FORCE_FALL_N_S = max(FORCE_RAMP_DOWN_N_S, FINGER_FORCE_N / (FORCE_SAFE_S - GAP_S - FORCE_MARGIN_S))


class ForceLimits:
    """One finger's; each tick `observe` what the force has done, then `step` to the next.

    Attributes:
        energy: of the port.
        force_n: let through last, N.
        out_of_range, overdrawn, ramped: whether range, energy or ramp acted in the last step.
    """

    def __init__(self, wall: SampledWall) -> None:
        """No force so far, on an exoskeleton that can show this wall."""
        self.energy = PassivityController(
            wall.stiffest_n_m, ACCOUNT_J, damping_n_s_m=wall.damping_n_s_m, delay_s=wall.delay_s
        )
        self._oscillation = OscillationDetector()
        self._watched_n = math.nan
        """Force that the oscillation was given last, N; NaN where it has begun anew."""
        self._ceiling_n = 0.0
        self.force_n = 0.0
        self.out_of_range = self.overdrawn = self.ramped = False

    def show(self, wall: SampledWall) -> None:
        """From now on a debt, too, is shown as no stiffer wall than this."""
        self.energy.show(wall.stiffest_n_m)

    def begin_from_neutral(self) -> None:
        """After a standstill: the device has let go by itself, or was about to."""
        self._ceiling_n = 0.0
        self.believe_again()

    def believe_again(self) -> None:
        """A person has cleared the fault: what swung before counts no more."""
        self._oscillation.begin_anew()
        self._watched_n = math.nan

    def observe(self, t_s: float, height_s: float, z_m: float) -> Fault | None:
        """Return what the force does that it must not, or None.

        Args:
            t_s: time, s.
            height_s: when the finger's height was measured, s.
            z_m: height of the finger, m; NaN where it is not known.
        """
        self.energy.observe(height_s, z_m)
        if self.force_n == self._watched_n and not self.overdrawn:
            return None  # a force that stays does not swing
        self._watched_n = self.force_n
        return self._oscillation.step(t_s, self.force_n, self.overdrawn)

    def step(self, t_s: float, dt_s: float, live: bool, age_s: float, wanted_n: float) -> float:
        """The force to let through, N.

        A ceiling rises from zero while live and falls otherwise; below it the contact law is untouched.

        Args:
            t_s: time, s.
            dt_s: since the last step, s.
            live: whether forces may act.
            age_s: of the input that they follow from, s.
            wanted_n: what is asked for, N.
        """
        if live:
            self._ceiling_n = min(FINGER_FORCE_N, self._ceiling_n + FORCE_RAMP_UP_N_S * dt_s)
        else:
            self.energy.rest()
            self.believe_again()
            shown_n = min(self._ceiling_n, self.force_n)
            latest_n = math.inf
            if age_s > GAP_S:
                latest_n = max(0.0, FORCE_FALL_N_S * (FORCE_SAFE_S - FORCE_MARGIN_S - age_s))
            self._ceiling_n = min(latest_n, max(0.0, shown_n - FORCE_FALL_N_S * dt_s))
        force_n = min(FINGER_FORCE_N, wanted_n) if wanted_n > 0.0 else 0.0
        self.out_of_range = force_n != wanted_n
        self.overdrawn = self.ramped = False
        if force_n > 0.0:
            payable_n = self.energy.limit_n()
            if force_n > payable_n:
                self.overdrawn, force_n = True, payable_n
            if force_n > self._ceiling_n:
                self.ramped, force_n = True, self._ceiling_n
        self.force_n = force_n
        self.energy.command(t_s, force_n)
        return force_n
