"""Drives the vibration motor with voltages that bring it to a wanted speed in the shortest time.

An eccentric-rotating-mass motor obeys `u = R i + k_e omega` and `J domega/dt = k_e i - b omega - T_f`. At the voltage
that holds a speed it needs 50 ms for two thirds of the speed, which is too late for every tap. The same equations
estimate its present speed, and so the pulse of higher or lower voltage that brings it to the wanted speed.
"""

import math
from dataclasses import dataclass
from functools import cached_property

from common.buses.serial_messages import MOTOR_MAX_MV, MOTOR_PULSE_MAX_US
from common.limits import MODULE_TIMEOUT_S, MOTOR_MAX_RPM

RPM_TO_RAD_S = math.pi / 30.0
CLOSE = 0.04
"""Relative speed error that pulses leave uncorrected, so that a motor with other constants does not overshoot."""
JUMP = 0.1
"""Relative rise of the wanted speed at once above which it counts as an impulse with a peak to display."""
JUMP_RAD_S = 30.0
"""Absolute rise of the wanted speed at once above which it counts as an impulse, rad/s; JUMP must be exceeded, too."""
PEAK_S = 0.05
"""Longest time to reach an impulse's peak while the wanted speed falls, s; longer than from rest to full speed."""
FULL_V = 1e-3 * MOTOR_MAX_MV
"""Full voltage, V, twice the voltage that holds the largest speed.

The driver is a single transistor. It cannot reverse the voltage, and brakes by shorting the motor.
"""


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
        """Voltage at which the torque just exceeds dry friction, V."""
        return self.friction_n_m * self.resistance_ohm / self.emf_v_s

    @cached_property
    def time_constant_s(self) -> float:
        """Mechanical time constant of the speed, s."""
        return self.inertia_kg_m2 / (self.viscous_n_m_s + self.emf_v_s**2 / self.resistance_ohm)

    @cached_property
    def _slope_v_s(self) -> float:
        return self.emf_v_s + self.resistance_ohm * self.viscous_n_m_s / self.emf_v_s

    def voltage_v(self, omega_rad_s: float) -> float:
        """Return the voltage that holds a speed, V; 0 for speeds of 0 and below."""
        return self.start_v + self._slope_v_s * omega_rad_s if omega_rad_s > 0.0 else 0.0

    def speed_rad_s(self, from_rad_s: float, volts: float, after_s: float) -> float:
        """Return the speed after a time at a constant voltage of 0 or more, rad/s, never below 0."""
        if from_rad_s == 0.0 and volts <= self.start_v:
            return 0.0
        final = (volts - self.start_v) / self._slope_v_s
        return max(0.0, final + (from_rad_s - final) * math.exp(-after_s / self.time_constant_s))

    def takes_s(self, from_rad_s: float, to_rad_s: float, volts: float) -> float:
        """Return the time from one speed to another at a voltage, s; infinite if it is never reached."""
        final = (volts - self.start_v) / self._slope_v_s
        share = (to_rad_s - final) / (from_rad_s - final) if from_rad_s != final else math.inf
        return -self.time_constant_s * math.log(share) if 0.0 < share <= 1.0 else math.inf

    def rise_s(self, omega_rad_s: float) -> float:
        """Return the shortest time from rest to a speed, s."""
        return self.takes_s(0.0, omega_rad_s, FULL_V)


MOTOR = Motor()


def motor_mv(rpm: float) -> int:
    """Return the voltage that holds a motor speed, mV.

    It is 0 for a zero, negative or non-finite speed. Higher speeds are limited to the motor's largest speed.
    """
    return _millivolts(MOTOR.voltage_v(_omega(rpm)))


class MotorDrive:
    """Drives one motor; call `step` for each command, at most MODULE_TIMEOUT_S after the one before.

    Attributes:
        hold_mv: present voltage, after the pulse, mV.
        pulse: voltage, mV, duration, us, and number of the present pulse; see `TactTipCommand`.
        speed_rad_s: estimated present speed of the motor by its constants, rad/s.
    """

    def __init__(self) -> None:
        self._t_s = -math.inf
        self.hold_mv = 0
        self.pulse = (0, 0, 0)
        self._pulse_until_s = -math.inf
        self._pulse_to = 0.0
        self._pulses = 0
        self._wanted = 0.0
        self._peak = 0.0
        self._peak_until_s = -math.inf
        self.speed_rad_s = 0.0

    def step(self, t_s: float, rpm: float) -> None:
        """Find voltage and pulse for the next command to the module; zero and non-finite speeds give 0 V."""
        if rpm == 0.0 == self.speed_rad_s and not self.hold_mv:  # at rest, and stays there
            self._t_s = self._pulse_until_s = t_s
            return
        self._advance(t_s)
        wanted = _omega(rpm)
        if wanted - self._wanted > max(JUMP_RAD_S, JUMP * self._wanted):
            self._peak, self._peak_until_s = wanted, t_s + PEAK_S
        self._wanted = wanted
        if wanted == 0.0 or self.speed_rad_s >= (1.0 - 1.5 * CLOSE) * self._peak or not t_s <= self._peak_until_s:
            self._peak = 0.0
        goal = max(wanted, self._peak)
        self.hold_mv = _millivolts(MOTOR.voltage_v(goal))
        self.pulse = self._pulse(t_s, goal)

    def _advance(self, t_s: float) -> None:
        since_s, before_s, self._t_s = t_s - self._t_s, self._t_s, t_s
        if not 0.0 <= since_s <= MODULE_TIMEOUT_S:
            # The module has switched its motor off by itself, or the clock was set back and the pulse is unknown.
            self.speed_rad_s, self._pulse_until_s = 0.0, -math.inf
            return
        pulse_s = min(since_s, max(0.0, self._pulse_until_s - before_s))
        speed = MOTOR.speed_rad_s(self.speed_rad_s, 1e-3 * self.pulse[0], pulse_s)
        self.speed_rad_s = MOTOR.speed_rad_s(speed, 1e-3 * self.hold_mv, since_s - pulse_s)

    def _pulse(self, t_s: float, goal: float) -> tuple[int, int, int]:
        """Return voltage, mV, duration, us, and number of the pulse that brings the motor to a speed, rad/s."""
        low, high = (1.0 - CLOSE) * goal, (1.0 + CLOSE) * goal
        if t_s < self._pulse_until_s and 0.0 < low <= self._pulse_to <= high:
            return self.pulse
        self._pulse_until_s = t_s
        if goal == 0.0 or low <= self.speed_rad_s <= high:
            return 0, 0, 0
        pulse_mv, self._pulse_to = (MOTOR_MAX_MV, low) if self.speed_rad_s < low else (0, high)
        pulse_s = MOTOR.takes_s(self.speed_rad_s, self._pulse_to, 1e-3 * pulse_mv)
        pulse_us = min(MOTOR_PULSE_MAX_US, round(1e6 * pulse_s))
        self._pulse_until_s, self._pulses = t_s + 1e-6 * pulse_us, (self._pulses + 1) & 0xFF
        return pulse_mv, pulse_us, self._pulses


def _omega(rpm: float) -> float:
    return min(rpm, MOTOR_MAX_RPM) * RPM_TO_RAD_S if math.isfinite(rpm) and rpm > 0.0 else 0.0


def _millivolts(volts: float) -> int:
    return min(MOTOR_MAX_MV, max(0, round(1000.0 * volts)))
