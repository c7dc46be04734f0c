"""Wave variables (Niemeyer & Slotine 1991): passive at any constant delay, as soft and as heavy as the delay is long.

    u = (b v + F) / sqrt(2 b),    w = (b v - F) / sqrt(2 b)

u travels to the remote site, w back. What is lost is held, and that is not passive: here it is shown as it is. With the
integral of u as a second row a lost or late packet costs no place.
"""

import math

import numpy as np

from sim_sensors.fingertip import SERVO_NS_M
from studies.stability_cases import Floats

WAVE_NS_M = 10.0
"""Wave impedance b: low, free motion is light; high, contact is stiff."""
DRIFT_PER_S = 2.0
"""How fast a place that packets lost have cost is corrected."""


class WaveVariables:
    """Velocity and force as waves, with the place corrected by the integral of u."""

    packet_rows = 2

    def __init__(self, start_m: Floats, period_s: float, wave_ns_m: float = WAVE_NS_M) -> None:
        self._period_s, self._b = period_s, wave_ns_m
        self._root = math.sqrt(2.0 * wave_ns_m)
        self._operator_m = self._remote_m = start_m
        self._sent, self._received, self._pace = np.zeros((3, len(start_m)))

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """F = b v - sqrt(2 b) w, and u = sqrt(2 b) v - w."""
        speed = (depth_m - self._operator_m) / self._period_s
        self._operator_m = depth_m
        u = self._root * speed - packet[0]
        self._sent = self._sent + self._period_s * u
        return self._b * speed - self._root * packet[0], np.stack((u, self._sent))

    def remote(
        self, depth_m: Floats, force_n: Floats, servo_n: Floats, packet: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Speed of the set-point out of u and the servo's force, w = (b v - F) / sqrt(2 b)."""
        del force_n, depth_m
        u = packet[0] + DRIFT_PER_S * (packet[1] - self._received)
        self._received = self._received + self._period_s * u
        # The servo's damper feels the new speed at once: solved for it, so that the wave is matched and nothing rings.
        spring_n = servo_n - SERVO_NS_M * self._pace
        self._pace = (self._root * u - spring_n) / (self._b + SERVO_NS_M)
        setpoint = self._remote_m
        self._remote_m = setpoint + self._period_s * self._pace
        w = (self._b * self._pace - (spring_n + SERVO_NS_M * self._pace)) / self._root
        return setpoint, self._pace, np.stack((w, self._received))
