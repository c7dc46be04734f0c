"""The vibration motor's steady state: which voltage holds which speed.

An eccentric-rotating-mass motor obeys `u = R i + k_e omega` and `J domega/dt = k_e i - b omega - T_f`.
At rest in omega this inverts exactly, and that is what is commanded; the approach to it is the motor's own.
"""

import math
from dataclasses import dataclass

from common.limits import MOTOR_MAX_RPM

RPM_TO_RAD_S = math.pi / 30.0
DEVICE_MAX_MV = 3000
"""Largest voltage that the module's command can carry, mV."""


@dataclass(frozen=True, slots=True)
class Motor:
    """Electrical and mechanical constants of one motor, SI."""

    resistance_ohm: float = 10.8
    emf_v_s: float = 6.4e-4
    viscous_n_m_s: float = 2.2e-8
    friction_n_m: float = 2.1e-5
    inertia_kg_m2: float = 3e-9

    @property
    def start_v(self) -> float:
        """Voltage at which the torque just beats dry friction, V."""
        return self.friction_n_m * self.resistance_ohm / self.emf_v_s

    @property
    def time_constant_s(self) -> float:
        """How fast the speed approaches its steady state, s."""
        return self.inertia_kg_m2 / (self.viscous_n_m_s + self.emf_v_s**2 / self.resistance_ohm)

    def voltage_v(self, omega_rad_s: float) -> float:
        """Voltage that holds a speed, V; zero for zero and below."""
        if not omega_rad_s > 0.0:
            return 0.0
        slope = self.emf_v_s + self.resistance_ohm * self.viscous_n_m_s / self.emf_v_s
        return self.start_v + slope * omega_rad_s


MOTOR = Motor()


def motor_mv(rpm: float, motor: Motor = MOTOR) -> int:
    """Voltage command for a motor speed, mV.

    Zero for zero, negative or non-finite speed; speeds above the motor's range count as its largest.
    """
    if not math.isfinite(rpm):
        return 0
    return min(DEVICE_MAX_MV, round(1000.0 * motor.voltage_v(min(rpm, MOTOR_MAX_RPM) * RPM_TO_RAD_S)))
