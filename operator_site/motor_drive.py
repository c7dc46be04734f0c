"""The vibration motor's drive: from the speed that should be felt to the voltage that brings the motor there in time.

An eccentric-rotating-mass motor obeys `u = R i + k_e omega` and `J domega/dt = k_e i - b omega - T_f`. Left alone at
the voltage that holds a speed it needs 50 ms for two thirds of it, and is late for every tap. The same equation says
how fast it turns by now, and so how much more, or less, brings it to its speed at once.
"""

import math
from dataclasses import dataclass

from common.limits import MODULE_TIMEOUT_S, MOTOR_MAX_RPM

RPM_TO_RAD_S = math.pi / 30.0
DEVICE_MAX_MV = 3000
"""Largest voltage that the module's command can carry, mV: twice what holds the largest speed. The driver is a single
transistor: it cannot turn the voltage round, and brakes by shorting the motor."""
CORRECTION_S = 0.006
"""What the speed lacks is made up in this time: one command and a half, so that a motor not quite as told settles."""
CLOSE = 0.04
"""A speed is corrected to within this part of its goal; the rest it goes by itself. A command that the line delays by a
millisecond brings it no further than the goal then."""
JUMP = 0.1
JUMP_RAD_S = 30.0
"""A wanted speed that rises by this part and this much at once is an impulse: its peak is to be felt."""
PEAK_S = 0.05
"""For so long an impulse's peak is still gone for although the wanted speed falls: from rest to full speed and more."""


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

    @property
    def _slope_v_s(self) -> float:
        return self.emf_v_s + self.resistance_ohm * self.viscous_n_m_s / self.emf_v_s

    def voltage_v(self, omega_rad_s: float) -> float:
        """Voltage that holds a speed, V; zero for zero and below."""
        return self.start_v + self._slope_v_s * omega_rad_s if omega_rad_s > 0.0 else 0.0

    def speed_rad_s(self, from_rad_s: float, volts: float, after_s: float) -> float:
        """Speed after some time at a constant voltage of 0 or more, never below 0."""
        final = (volts - self.start_v) / self._slope_v_s
        return max(0.0, final + (from_rad_s - final) * math.exp(-after_s / self.time_constant_s))

    def rise_s(self, omega_rad_s: float, volts: float = 1e-3 * DEVICE_MAX_MV) -> float:
        """Time from rest to a speed at a voltage, s; infinite where it never gets there."""
        final = (volts - self.start_v) / self._slope_v_s
        return -self.time_constant_s * math.log(1.0 - omega_rad_s / final) if omega_rad_s < final else math.inf


MOTOR = Motor()


def motor_mv(rpm: float, motor: Motor = MOTOR) -> int:
    """Voltage that holds a motor speed, mV.

    Zero for zero, negative or non-finite speed; speeds above the motor's range count as its largest.
    """
    return _millivolts(motor.voltage_v(_omega(rpm)))


class MotorDrive:
    """Drives one motor: `step` for each command, at most MODULE_TIMEOUT_S after the one before.

    Attributes:
        speed_rad_s: how fast the motor turns by now, if it is as told.
    """

    def __init__(self, motor: Motor = MOTOR) -> None:
        self._motor = motor
        self._t_s = -math.inf
        self._volts = 0.0
        self._wanted = 0.0
        self._peak = 0.0
        self._peak_until_s = -math.inf
        self.speed_rad_s = 0.0

    def step(self, t_s: float, rpm: float) -> int:
        """Voltage from `t_s` on for a wanted speed, mV; no speed, or one that is no number, is no voltage."""
        since_s, self._t_s = t_s - self._t_s, t_s
        if 0.0 <= since_s <= MODULE_TIMEOUT_S:
            self.speed_rad_s = self._motor.speed_rad_s(self.speed_rad_s, self._volts, since_s)
        else:
            self.speed_rad_s = 0.0  # the module has switched its motor off by itself
        wanted = _omega(rpm)
        if wanted - self._wanted > max(JUMP_RAD_S, JUMP * self._wanted):
            self._peak, self._peak_until_s = wanted, t_s + PEAK_S
        self._wanted = wanted
        if wanted == 0.0 or self.speed_rad_s >= (1.0 - 1.5 * CLOSE) * self._peak or not t_s <= self._peak_until_s:
            self._peak = 0.0
        millivolts = self._drive(max(wanted, self._peak))
        self._volts = 1e-3 * millivolts
        return millivolts

    def _drive(self, goal: float) -> int:
        """Voltage that brings the motor to a speed and holds it there."""
        if goal == 0.0:
            return 0
        motor, speed = self._motor, self.speed_rad_s
        lacking = min(max(speed, (1.0 - CLOSE) * goal), (1.0 + CLOSE) * goal) - speed
        correction = lacking / CORRECTION_S * motor.inertia_kg_m2 * motor.resistance_ohm / motor.emf_v_s
        return _millivolts(motor.voltage_v(goal) + correction)


def _omega(rpm: float) -> float:
    return min(rpm, MOTOR_MAX_RPM) * RPM_TO_RAD_S if math.isfinite(rpm) and rpm > 0.0 else 0.0


def _millivolts(volts: float) -> int:
    return min(DEVICE_MAX_MV, max(0, round(1000.0 * volts)))
