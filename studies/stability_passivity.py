"""Position and servo force with time-domain passivity: an observer and a controller at both ports.

Energy is split by its sign (Hannaford & Ryu 2002, Ryu et al. 2010): no port may give out more than the other had taken
in when the packet left it. What would be too much, a damper takes: at the operator a force, at the remote site a speed.
What comes back is the servo's force, not the wall's: it is the one that the energy of the remote port belongs to.
"""

import numpy as np

from studies.stability_cases import Floats

MOST_NS_M = 15.0
"""Largest damper at the operator: more would shake the light finger by itself at a period of some milliseconds."""
MOST_M_S_N = 0.04
"""Largest damper at the remote site: more, times the servo's own 15 Ns/m, would chatter from tick to tick."""
STILL_M_S, SLACK_N = 1e-3, 0.02
DRIFT_PER_S = 10.0
"""How fast a place that the damper has cost is corrected, as far as there is energy (after Coelho et al. 2019)."""


class PassivityControl:
    """Observer and controller at both ports."""

    packet_rows = 2

    def __init__(self, start_m: Floats, period_s: float) -> None:
        self._period_s = period_s
        self._start_m = self._operator_m = self._commanded_m = self._heard_m = start_m
        self._operator_in, self._operator_out, self._remote_in, self._remote_out = np.zeros((4, len(start_m)))
        self._shown_n, self._pace = np.zeros((2, len(start_m)))

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """The remote force, and a damper on what the remote site had not taken in."""
        moved = depth_m - self._operator_m
        self._operator_m = depth_m
        work = self._shown_n * moved
        self._operator_in = self._operator_in + np.maximum(0.0, work)
        self._operator_out = self._operator_out + np.maximum(0.0, -work)
        speed = moved / self._period_s
        force, allowed = packet[0], packet[1]
        # Energy that this force would give out by the next tick, should the finger move on as it does.
        excess = self._operator_out + np.maximum(0.0, -force * moved) - allowed
        moving = np.abs(speed) > STILL_M_S
        damper = np.where(moving, np.maximum(0.0, excess) / (self._period_s * np.maximum(speed**2, STILL_M_S**2)), 0.0)
        self._shown_n = force + np.minimum(MOST_NS_M, damper) * speed
        return self._shown_n, np.stack((depth_m - self._start_m, self._operator_in))

    def remote(
        self, depth_m: Floats, force_n: Floats, servo_n: Floats, packet: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """The operator's speed, less what the energy that has arrived does not pay for."""
        del depth_m, force_n
        work = servo_n * self._pace * self._period_s
        self._remote_out = self._remote_out + np.maximum(0.0, work)
        self._remote_in = self._remote_in + np.maximum(0.0, -work)
        wanted = self._start_m + packet[0]
        pace = (wanted - self._heard_m) / self._period_s + DRIFT_PER_S * (self._heard_m - self._commanded_m)
        self._heard_m = wanted
        excess = self._remote_out + np.maximum(0.0, servo_n * pace * self._period_s) - packet[1]
        pressing = np.abs(servo_n) > SLACK_N
        damper = np.where(
            pressing, np.maximum(0.0, excess) / (self._period_s * np.maximum(servo_n**2, SLACK_N**2)), 0.0
        )
        self._pace = pace - np.minimum(MOST_M_S_N, damper) * servo_n
        setpoint = self._commanded_m
        self._commanded_m = setpoint + self._period_s * self._pace
        return setpoint, self._pace, np.stack((servo_n, self._remote_in))
