"""Position and servo force with time-domain passivity control: a passivity observer and controller at both ports.

Energy is split by its sign (Hannaford & Ryu 2002, Ryu et al. 2010). No port may give out more energy than the other had
taken in when the packet left it. A damper absorbs the excess: a force at the operator, a speed at the remote site. The
servo's force returns instead of the wall's, because the energy of the remote port is that of the servo.
"""

import numpy as np

from studies.teleoperation_stability.cases import Floats, Measured

MOST_NS_M = 15.0
"""Largest damping at the operator, Ns/m; more would shake the light finger at a period of some milliseconds."""
MOST_M_S_N = 0.04
"""Largest damping at the remote site, m/s per N; more would chatter with the servo's own 15 Ns/m."""
STILL_M_S, SLACK_N = 1e-3, 0.02
DRIFT_PER_S = 10.0
"""Rate of correcting the position drift caused by the damper, 1/s, as energy allows (after Coelho et al. 2019)."""


class PassivityControl:
    """Passivity observer and controller at both ports."""

    packet_rows = 2

    def __init__(self, start_m: Floats, period_s: float) -> None:
        self._period_s = period_s
        self._start_m = self._operator_m = self._commanded_m = self._heard_m = start_m
        self._operator_in, self._operator_out, self._remote_in, self._remote_out = np.zeros((4, len(start_m)))
        self._shown_n, self._pace = np.zeros((2, len(start_m)))

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Show the remote force, with damping of the energy that the remote site had not taken in."""
        moved = depth_m - self._operator_m
        self._operator_m = depth_m
        work = self._shown_n * moved
        self._operator_in = self._operator_in + np.maximum(0.0, work)
        self._operator_out = self._operator_out + np.maximum(0.0, -work)
        speed = moved / self._period_s
        force, allowed = packet[0], packet[1]
        # Energy that this force gives out by the next tick if the finger keeps its speed.
        excess = self._operator_out + np.maximum(0.0, -force * moved) - allowed
        moving = np.abs(speed) > STILL_M_S
        damper = np.where(moving, np.maximum(0.0, excess) / (self._period_s * np.maximum(speed**2, STILL_M_S**2)), 0.0)
        self._shown_n = force + np.minimum(MOST_NS_M, damper) * speed
        return self._shown_n, np.stack((depth_m - self._start_m, self._operator_in))

    def remote(self, at: Measured, packet: Floats) -> tuple[Floats, Floats, Floats]:
        """Follow the operator's speed, less the part that the arrived energy does not cover."""
        servo_n = at.servo_n
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
