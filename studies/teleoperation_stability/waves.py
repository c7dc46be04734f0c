"""Wave variables (Niemeyer & Slotine 1991): passive at any constant delay, but softer and heavier with longer delay.

    u = (b v + F) / sqrt(2 b),    w = (b v - F) / sqrt(2 b)

u travels to the remote site, and w returns. The last packet is held after a loss, which is not passive and is left
uncorrected here. Packets also carry the integral of u, so that a lost or late packet causes no position drift.
"""

import math

import numpy as np

from sim_sensors.physics.fingertip import SERVO_NS_M
from studies.teleoperation_stability.cases import Floats, Measured

WAVE_NS_M = 10.0
"""Wave impedance b, Ns/m; a low one makes free motion light, a high one makes contact stiff."""
DRIFT_PER_S = 2.0
"""Rate of correcting the position drift caused by lost packets, 1/s."""


class WaveVariables:
    """Velocity and force as waves, with the position corrected by the integral of u."""

    packet_rows = 2

    def __init__(self, start_m: Floats, period_s: float) -> None:
        self._period_s = period_s
        self._root = math.sqrt(2.0 * WAVE_NS_M)
        self._operator_m = self._remote_m = start_m
        self._sent, self._received, self._pace = np.zeros((3, len(start_m)))

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Return F = b v - sqrt(2 b) w, and u = sqrt(2 b) v - w with its integral."""
        speed = (depth_m - self._operator_m) / self._period_s
        self._operator_m = depth_m
        u = self._root * speed - packet[0]
        self._sent = self._sent + self._period_s * u
        return WAVE_NS_M * speed - self._root * packet[0], np.stack((u, self._sent))

    def remote(self, at: Measured, packet: Floats) -> tuple[Floats, Floats, Floats]:
        """Return set-point and speed from u and the servo's force, and w = (b v - F) / sqrt(2 b)."""
        u = packet[0] + DRIFT_PER_S * (packet[1] - self._received)
        self._received = self._received + self._period_s * u
        # The servo's damper acts on the new speed at once. Solving for this speed matches the wave and avoids ringing.
        spring_n = at.servo_n - SERVO_NS_M * self._pace
        self._pace = (self._root * u - spring_n) / (WAVE_NS_M + SERVO_NS_M)
        setpoint = self._remote_m
        self._remote_m = setpoint + self._period_s * self._pace
        w = (WAVE_NS_M * self._pace - (spring_n + SERVO_NS_M * self._pace)) / self._root
        return setpoint, self._pace, np.stack((w, self._received))
