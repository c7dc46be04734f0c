"""The one table of limits: everything that may reach a finger or a patient stays inside it.

Gates, device emulators' checks, tests and the documentation all read these numbers; no other
module states a limit of its own.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PlateRange:
    """Set-points that an operator's fingertip plate may be given, C."""

    low_c: float
    high_c: float


COMFORT = PlateRange(20.0, 38.0)
WIDE = PlateRange(15.0, 41.5)
PLATE_PROFILES = {"comfort": COMFORT, "wide": WIDE}

PLATE_FAULT_C = 42.0
"""An operator plate above this is a fault, C."""
PLATE_PEAK_C = 43.0
"""No single fault starting at or below 40 C may heat a plate beyond this, C."""
PLATE_HEATING_K_S = 4.0
PLATE_COOLING_K_S = 2.5
"""Largest rates of change of a plate's set-point, K/s (Kron & Schmidt 2003, section 2)."""

DOSE_ABOVE_C = 40.0
DOSE_LIMIT_K_S = 20.0
DOSE_WINDOW_S = 60.0
"""Skin dose: the integral of max(0, T - 40 C) over any 60 s stays at or below 20 K s."""

FINGER_FORCE_N = 10.0
FORCE_RAMP_UP_N_S = 50.0
FORCE_RAMP_DOWN_N_S = 200.0
"""Ramps on engaging, disengaging and model updates, N/s. Never inside the contact law."""

PRODUCED_J = 0.0005
"""So much energy may come out at an operator's finger beyond what it put in, before force is let go, J."""
ACCOUNT_J = 0.005
"""Maximum energy that a finger has put in and that may be given back to it, J: 2 N over 2.5 mm."""
FORGIVEN_W = 0.00015
"""What has come out too much is forgotten at this rate while no force acts, W: a press that was interrupted is felt
again without being lifted first, and nothing is pumped by it that a finger's own damping does not take."""
SWING_N = 0.4
SWING_CYCLES, SWING_S = 6, 0.5
"""A force that swings by so much is a fault when it does so in so many cycles within this time: no hand can."""
SWING_SLOW_HZ, SWING_SLOW_CYCLES = 3.0, 3
"""Slower than that, a hand can: a fault when the energy limit has to act in each of so many cycles."""

MOTOR_MAX_RPM = 10_000.0
MOTOR_FLOOR_RPM = 2740.0
"""Below this a vibration of the motor's fixed amplitude is not felt: command it or zero, nothing between."""

SENSOR_PLATE_C = 42.0
"""A thermal sensor's plate touches a patient: never above this, C."""
CONTACT_FORCE_N = 5.0
"""Default largest force of a remote finger on the patient, N."""
LEFT_J, LEFT_W = 0.050, 0.100
"""Work that a remote finger may leave in the patient beyond what comes back: at once, J, and lastingly, W."""
APPROACH_PLANE_M_S, APPROACH_DOWN_M_S = 0.15, 0.020
"""Until the remote hand has met the operator's hand: its speed along the bench, and of its fingers downwards."""

GAP_S = 0.100
"""No accepted packet for this long means safe state."""
AGE_DEFAULT_S = 0.150
AGE_MAX_S = 0.500
"""Oldest source time acted on: agreed at engage, never above the maximum."""
FORCE_SAFE_S = 0.150
MOTOR_SAFE_S = 0.150
MOTOR_STILL_S = 0.250
THERMAL_SAFE_S = 0.200
"""From the last valid input to safe output: force 0, motor drive 0, motor below its floor, Peltier and heater 0."""
MODULE_TIMEOUT_S = 0.100
"""A device that hears nothing for this long switches its own outputs off."""
