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

MOTOR_MAX_RPM = 10_000.0
MOTOR_FLOOR_RPM = 2740.0
"""Below this a vibration of the motor's fixed amplitude is not felt: command it or zero, nothing between."""

SENSOR_PLATE_C = 42.0
"""A thermal sensor's plate touches a patient: never above this, C."""
CONTACT_FORCE_N = 5.0
"""Default largest force of a remote finger on the patient, N."""

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
