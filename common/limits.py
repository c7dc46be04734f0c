"""Limits of every output to a finger or a patient, in one table.

Gates, device emulators, tests and the documentation read these numbers. No other module states a limit of its own.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PlateRange:
    """Range of set-points of an operator's fingertip plate, C."""

    low_c: float
    high_c: float


COMFORT = PlateRange(20.0, 38.0)
WIDE = PlateRange(15.0, 41.5)
PLATE_PROFILES = {"comfort": COMFORT, "wide": WIDE}

PLATE_FAULT_C = 42.0
"""Maximum temperature of an operator plate, C; a higher one is a fault."""
PLATE_PEAK_C = 43.0
"""Maximum temperature of a plate after any single fault that starts at or below 40 C, C."""
PLATE_HEATING_K_S = 4.0
"""Maximum rise of a plate's set-point, K/s (Kron & Schmidt 2003, section 2)."""
PLATE_COOLING_K_S = 2.5
"""Maximum fall of a plate's set-point, K/s (Kron & Schmidt 2003, section 2)."""

DOSE_ABOVE_C = 40.0
"""Temperature above which skin collects thermal dose, C."""
DOSE_LIMIT_K_S = 20.0
"""Maximum thermal dose, the integral of max(0, T - 40 C) over any 60 s, K s."""
DOSE_WINDOW_S = 60.0
"""Window of the thermal dose, s."""

FINGER_FORCE_N = 10.0
"""Maximum force on an operator's finger, N."""
FORCE_RAMP_UP_N_S = 50.0
"""Maximum rise of the force on engaging and on model updates, N/s. The contact law itself has no rate limit."""
FORCE_RAMP_DOWN_N_S = 200.0
"""Rate at which the force falls on disengaging and on model updates, N/s. The contact law itself has no rate limit."""

PRODUCED_J = 0.0005
"""Maximum energy that an operator's finger may receive beyond its own input, J; at more, force is released."""
ACCOUNT_J = 0.005
"""Maximum stored energy that a finger has put in and may get back, J: 2 N over 2.5 mm."""
FORGIVEN_W = 0.00015
"""Rate at which excess energy is forgotten while no force acts, W. After an interrupted press a finger feels force
again without lifting first. A finger's own damping absorbs more energy than repeated presses can gain by it."""
SWING_N = 0.4
SWING_CYCLES, SWING_S = 6, 0.5
"""Number of cycles and duration, s, at which a force oscillation of SWING_N is a fault: no hand oscillates as fast."""
SWING_SLOW_HZ, SWING_SLOW_CYCLES = 3.0, 3
"""Minimum frequency, Hz, and number of cycles at which a slower oscillation is a fault. A hand can oscillate as fast,
so the energy limit must act in each of these cycles."""

MOTOR_MAX_RPM = 10_000.0
MOTOR_FLOOR_RPM = 2740.0
"""Minimum motor speed whose vibration a finger perceives, rpm; a command is 0 or at least this."""

SENSOR_PLATE_C = 42.0
"""Maximum temperature of a thermal sensor's plate, which touches a patient, C."""
CONTACT_FORCE_N = 5.0
"""Default maximum force of a remote finger on the patient, N."""
LEFT_J, LEFT_W = 0.050, 0.100
"""Maximum work of a remote finger that stays in the patient: at once, J, and continuously, W."""
RETREAT_M_S = 0.020
"""Speed at which a stopped remote finger leaves the patient along the surface normal, m/s."""
PATIENT_STOP_S = 0.150
"""Maximum time from a press of the patient's stop switch until the contact force falls, s; it needs no network."""
LIFT_OFF_S = 0.900
"""Maximum time from that press until a finger 10 mm deep at 5 N has left the patient, s. It is PATIENT_STOP_S and the
retreat over these 10 mm and the 5 mm by which the set-point lies below the finger."""
SWITCH_SILENCE_S = 0.100
"""Maximum silence of the patient's stop switch, s; a longer one stops the remote fingers as a press does."""
SWITCH_LOST_S = 0.500
"""Silence of the patient's stop switch that is a fault, s."""
SWITCH_HOLD_S = 1.000
"""Minimum time for which the patient's stop switch reports a press, s: longer than a silence, which could hide it."""
PAIN_SHARE = 0.8
"""Limit of the contact force after a report of pain, as a share of the patient's own threshold."""
PAIN_LEAST_N = 0.5
"""Lowest limit that a report of pain sets, N; a finger must still find the surface."""
APPROACH_PLANE_M_S, APPROACH_DOWN_M_S = 0.15, 0.020
"""Maximum speeds of the remote hand, m/s, along the bench and of fingers downwards, until it meets the operator's."""
REMOTE_PLANE_M = 0.655
"""Largest coordinate of the remote hand along the bench that the telemanipulator's frames can hold, m."""
REMOTE_LOW_M = -0.0100
"""Lowest height of a remote finger that these frames can hold, m."""

MOTION_SCALES = (1, 2, 5)
"""Ratios of the hand's motion to the remote hand's; the limits of the remote hand stay in its own units."""
COUPLING_STEP_M, COUPLING_STEP_N = 0.1e-3, 0.05
"""Maximum step of the command, m, and of a finger's force, N, at a change of clutch or scale."""
COUPLING_RAMP_N_S = 25.0
"""Rate at which a force falls while the clutch opens and rises after it closes, N/s."""

GAP_S = 0.100
"""Maximum gap between accepted packets, s; a longer gap causes the safe state."""
AGE_DEFAULT_S = 0.150
"""Default maximum age of a packet, s; an older packet is refused. The sites agree on it at engage."""
AGE_MAX_S = 0.500
"""Largest maximum age of a packet that may be configured, s."""
FORCE_SAFE_S = 0.150
"""Maximum time from the last valid input until force is 0, s."""
MOTOR_SAFE_S = 0.150
"""Maximum time from the last valid input until the motor drive is 0, s."""
MOTOR_STILL_S = 0.250
"""Maximum time from the last valid input until the motor is below its floor, s."""
THERMAL_SAFE_S = 0.200
"""Maximum time from the last valid input until Peltier and heater drives are 0, s."""
FROZEN_S = 0.450
"""Maximum age of a live picture of the camera, s; the page has named an older one 0.5 s after its capture. It pauses a
session that needs it."""
VOICE_AGE_S = 0.500
"""Maximum age of a sound of the voice that is played, s; an older one is dropped, and none waits behind it."""
MODULE_TIMEOUT_S = 0.100
"""Maximum time without a command at a device, s; after it the device turns its own outputs off."""
