"""The vibration motor's drive: from the speed that should be felt to the voltage that brings the motor there in time.

An eccentric-rotating-mass motor obeys `u = R i + k_e omega` and `J domega/dt = k_e i - b omega - T_f`. Left alone at
the voltage that holds a speed it needs 50 ms for two thirds of it, and is late for every tap. The same equation says
how fast it turns by now, and so how much more, or less, brings it to its speed at once.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from common.buses.serial_messages import MOTOR_MAX_MV, MOTOR_PULSE_MAX_US
from common.limits import MODULE_TIMEOUT_S, MOTOR_MAX_RPM

RPM_TO_RAD_S = math.pi / 30.0
CLOSE = 0.04
"""A speed is corrected to within this part of its goal; the rest it goes by itself, so that a motor not quite as told
comes no further than the goal."""
JUMP = 0.1
JUMP_RAD_S = 30.0
"""A wanted speed that rises by this part and this much at once is an impulse: its peak is to be felt."""
PEAK_S = 0.05
"""For so long an impulse's peak is still gone for although the wanted speed falls: from rest to full speed and more."""


FULL_V = 1e-3 * MOTOR_MAX_MV
"""Twice what holds the largest speed. The driver is a single transistor: it cannot turn the voltage round, and brakes
by shorting the motor."""


class MotorVoltage(NamedTuple):
    """What a module is told for its motor: once for each number `pulse_mv` for `pulse_us`, then `hold_mv`."""

    hold_mv: int
    pulse_mv: int = 0
    pulse_us: int = 0
    pulse_number: int = 0


OFF = MotorVoltage(0)


@dataclass(frozen=True)
class Motor:
    """Electrical and mechanical constants of one motor, SI."""

    resistance_ohm: float = 10.8
    emf_v_s: float = 6.4e-4
    viscous_n_m_s: float = 2.2e-8
    friction_n_m: float = 2.1e-5
    inertia_kg_m2: float = 3e-9

    @cached_property
    def start_v(self) -> float:
        """Voltage at which the torque just beats dry friction, V."""
        return self.friction_n_m * self.resistance_ohm / self.emf_v_s

    @cached_property
    def time_constant_s(self) -> float:
        """How fast the speed approaches its steady state, s."""
        return self.inertia_kg_m2 / (self.viscous_n_m_s + self.emf_v_s**2 / self.resistance_ohm)

    @cached_property
    def _slope_v_s(self) -> float:
        return self.emf_v_s + self.resistance_ohm * self.viscous_n_m_s / self.emf_v_s

    def voltage_v(self, omega_rad_s: float) -> float:
        """Voltage that holds a speed, V; zero for zero and below."""
        return self.start_v + self._slope_v_s * omega_rad_s if omega_rad_s > 0.0 else 0.0

    def speed_rad_s(self, from_rad_s: float, volts: float, after_s: float) -> float:
        """Speed after some time at a constant voltage of 0 or more, never below 0."""
        if from_rad_s == 0.0 and volts <= self.start_v:
            return 0.0
        final = (volts - self.start_v) / self._slope_v_s
        return max(0.0, final + (from_rad_s - final) * math.exp(-after_s / self.time_constant_s))

    def takes_s(self, from_rad_s: float, to_rad_s: float, volts: float) -> float:
        """Time from one speed to another at a voltage, s; infinite where it never gets there."""
        final = (volts - self.start_v) / self._slope_v_s
        share = (to_rad_s - final) / (from_rad_s - final) if from_rad_s != final else math.inf
        return -self.time_constant_s * math.log(share) if 0.0 < share <= 1.0 else math.inf

    def rise_s(self, omega_rad_s: float) -> float:
        """Least time from rest to a speed, s."""
        return self.takes_s(0.0, omega_rad_s, FULL_V)


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
        self._told = OFF
        self._pulse_until_s = -math.inf
        self._pulse_to = 0.0
        self._pulse_number = 0
        self._wanted = 0.0
        self._peak = 0.0
        self._peak_until_s = -math.inf
        self.speed_rad_s = 0.0

    def step(self, t_s: float, rpm: float) -> MotorVoltage:
        """What to tell the module at `t_s` for a wanted speed; no speed, or one that is no number, is no voltage."""
        if rpm == 0.0 == self.speed_rad_s and self._told == OFF:  # at rest, and stays there
            self._t_s = self._pulse_until_s = t_s
            return OFF
        self._advance(t_s)
        wanted = _omega(rpm)
        if wanted - self._wanted > max(JUMP_RAD_S, JUMP * self._wanted):
            self._peak, self._peak_until_s = wanted, t_s + PEAK_S
        self._wanted = wanted
        if wanted == 0.0 or self.speed_rad_s >= (1.0 - 1.5 * CLOSE) * self._peak or not t_s <= self._peak_until_s:
            self._peak = 0.0
        self._told = self._drive(t_s, max(wanted, self._peak))
        return self._told

    def _advance(self, t_s: float) -> None:
        since_s, before_s, self._t_s = t_s - self._t_s, self._t_s, t_s
        if not 0.0 <= since_s <= MODULE_TIMEOUT_S:
            # The module has switched its motor off by itself; or the clock was set back, and no pulse is known.
            self.speed_rad_s, self._pulse_until_s = 0.0, -math.inf
            return
        pulse_s = min(since_s, max(0.0, self._pulse_until_s - before_s))
        speed = self._motor.speed_rad_s(self.speed_rad_s, 1e-3 * self._told.pulse_mv, pulse_s)
        self.speed_rad_s = self._motor.speed_rad_s(speed, 1e-3 * self._told.hold_mv, since_s - pulse_s)

    def _drive(self, t_s: float, goal: float) -> MotorVoltage:
        """Voltages that bring the motor to a speed as fast as may be, and hold it there."""
        low, high = (1.0 - CLOSE) * goal, (1.0 + CLOSE) * goal
        hold_mv = _millivolts(self._motor.voltage_v(goal))
        if t_s < self._pulse_until_s and 0.0 < low <= self._pulse_to <= high:
            return self._told._replace(hold_mv=hold_mv)
        self._pulse_until_s = t_s
        if goal == 0.0 or low <= self.speed_rad_s <= high:
            return MotorVoltage(hold_mv)
        pulse_mv, self._pulse_to = (MOTOR_MAX_MV, low) if self.speed_rad_s < low else (0, high)
        pulse_s = self._motor.takes_s(self.speed_rad_s, self._pulse_to, 1e-3 * pulse_mv)
        pulse_us = min(MOTOR_PULSE_MAX_US, round(1e6 * pulse_s))
        self._pulse_until_s, self._pulse_number = t_s + 1e-6 * pulse_us, (self._pulse_number + 1) & 0xFF
        return MotorVoltage(hold_mv, pulse_mv, pulse_us, self._pulse_number)


def _omega(rpm: float) -> float:
    return min(rpm, MOTOR_MAX_RPM) * RPM_TO_RAD_S if math.isfinite(rpm) and rpm > 0.0 else 0.0


def _millivolts(volts: float) -> int:
    return min(MOTOR_MAX_MV, max(0, round(1000.0 * volts)))
