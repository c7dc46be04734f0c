"""Simulate the TactTip's vibration motor: an eccentric mass on a small DC motor.

    u = R i + k_e omega                      (armature; inductance neglected: 0.1 ms against 50 ms)
    J d(omega)/dt = k_t i - b omega - T_f    (one direction only: the module's driver is one transistor)

The motor stands still until its torque exceeds the stiction. At 0 V the driver shorts the motor, so that its
back-EMF brakes it.
"""

import math

import numpy as np
from numpy.typing import NDArray

RESISTANCE_OHM = 10.8
TORQUE_CONSTANT = 6.4e-4
"""Torque constant k_t, N m/A, equal to the back-EMF constant k_e, V s/rad."""
INERTIA_KG_M2 = 3e-9
VISCOUS_N_M_S = 2.2e-8
FRICTION_N_M = 2.1e-5
STICTION_N_M = 2.3e-5
"""Torque needed to start, N m: a standing motor starts at 0.39 V; running friction alone would need 0.35 V."""

SUBSTEP_S = 0.001
RPM_PER_RAD_S = 60.0 / (2.0 * math.pi)

_LOSS = VISCOUS_N_M_S + TORQUE_CONSTANT**2 / RESISTANCE_OHM
_STARTS_V = 0.99 * STICTION_N_M * RESISTANCE_OHM / TORQUE_CONSTANT
"""Voltage below which no motor starts, V."""
TIME_CONSTANT_S = INERTIA_KG_M2 / _LOSS
"""Mechanical time constant, s: inertia over friction and back-EMF, about 50 ms."""


class VibrationMotors:
    """A row of vibration motors, each with its own voltage.

    Attributes:
        speed_rad_s: present speed of each motor, never negative.
    """

    def __init__(self, count: int) -> None:
        self.speed_rad_s: NDArray[np.float64] = np.zeros(count)

    @property
    def rpm(self) -> NDArray[np.float64]:
        """Present speed of each motor, revolutions per minute."""
        return self.speed_rad_s * RPM_PER_RAD_S

    def step(self, dt_s: float, volts: NDArray[np.float64]) -> None:
        """Advance by `dt_s` at constant `volts` (one per motor, 0 V or more).

        Between stiction checks (at least one a millisecond), the equation is linear and solved exactly.
        """
        speeds: list[float] = self.speed_rad_s.tolist()
        pushed: list[float] = volts.tolist()
        if not any(speeds) and max(pushed) <= _STARTS_V:
            return
        substeps = max(1, math.ceil(dt_s / SUBSTEP_S - 1e-9))
        keep = math.exp(-dt_s / substeps / TIME_CONSTANT_S)
        for motor, volt in enumerate(pushed):
            torque = volt * (TORQUE_CONSTANT / RESISTANCE_OHM)
            final = (torque - FRICTION_N_M) * (1.0 / _LOSS)
            speed = speeds[motor]
            for _ in range(substeps):
                if torque > STICTION_N_M or speed > 0.0:
                    speed = max(0.0, final + (speed - final) * keep)
            speeds[motor] = speed
        self.speed_rad_s = np.array(speeds)
