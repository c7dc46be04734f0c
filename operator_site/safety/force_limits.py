"""Limits one finger's force in range, energy and ramps, and detects oscillation."""

import math

from common.faults.fault import Fault
from common.limits import ACCOUNT_J, FINGER_FORCE_N, FORCE_RAMP_DOWN_N_S, FORCE_RAMP_UP_N_S, FORCE_SAFE_S, GAP_S
from common.safety.oscillation_detector import OscillationDetector
from operator_site.safety.passivity_controller import PassivityController
from operator_site.safety.sampled_wall import SampledWall

FORCE_MARGIN_S = 0.010
"""Time from zero force to the deadline, s, for the tick that sends it and the bus."""
FORCE_FALL_N_S = max(FORCE_RAMP_DOWN_N_S, FINGER_FORCE_N / (FORCE_SAFE_S - GAP_S - FORCE_MARGIN_S))
"""Rate of a force that falls to zero while forces may not act, N/s."""


class ForceLimits:
    """Limits of one finger; in each tick `observe` the effect of the force, then `step` to the next force.

    Attributes:
        energy: energy of the port.
        force_n: last permitted force, N.
        out_of_range, overdrawn, ramped: whether range, energy or ramp acted in the last step.
    """

    def __init__(self, wall: SampledWall) -> None:
        """Begin without force, on an exoskeleton that can display this wall."""
        self.energy = PassivityController(
            wall.stiffest_n_m, ACCOUNT_J, damping_n_s_m=wall.damping_n_s_m, delay_s=wall.delay_s
        )
        self._oscillation = OscillationDetector()
        self._watched_n = math.nan
        """Last force that the detector of oscillation has taken, N; NaN after a restart."""
        self._ceiling_n = 0.0
        self.force_n = 0.0
        self.out_of_range = self.overdrawn = self.ramped = False

    def show(self, wall: SampledWall) -> None:
        """Set the bound of the walls; a debt of energy is displayed as no stiffer wall."""
        self.energy.show(wall.stiffest_n_m)

    def begin_from_neutral(self) -> None:
        """Begin from zero force after a standstill, because the device has released by itself."""
        self._ceiling_n = 0.0
        self._forget_swings()

    def _forget_swings(self) -> None:
        """Forget earlier oscillations, because the force is released."""
        self._oscillation.restart()
        self._watched_n = math.nan

    def observe(self, t_s: float, height_s: float, z_m: float) -> Fault | None:
        """Return the fault of a force that oscillates; None without one.

        Args:
            t_s: time, s.
            height_s: time at which the finger's height was measured, s.
            z_m: height of the finger, m; NaN if unknown.
        """
        self.energy.observe(height_s, z_m)
        if self.force_n == self._watched_n and not self.overdrawn:
            return None  # a constant force does not oscillate
        self._watched_n = self.force_n
        return self._oscillation.step(t_s, self.force_n, self.overdrawn)

    def step(self, t_s: float, dt_s: float, live: bool, age_s: float, wanted_n: float) -> float:
        """Return the permitted force, N.

        A ceiling rises from zero while live. Otherwise it falls, and is no higher than the force. Below it the contact
        law is untouched.

        Args:
            t_s: time, s.
            dt_s: time since the last step, s.
            live: whether forces may act.
            age_s: age of the input from which the force follows, s.
            wanted_n: requested force, N.
        """
        if live:
            self._ceiling_n = min(FINGER_FORCE_N, self._ceiling_n + FORCE_RAMP_UP_N_S * dt_s)
        else:
            self.energy.rest()
            self._forget_swings()
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
        if not live:
            self._ceiling_n = min(self._ceiling_n, force_n)
        self.force_n = force_n
        self.energy.command(t_s, force_n)
        return force_n
