"""Measures the tactile features of a stroke, from the speed of the TactTip's motor and from the real surface."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from common.limits import MOTOR_FLOOR_RPM
from sim_sensors.physics.motor import RPM_PER_RAD_S
from sim_sensors.physics.surface import SurfaceProfile
from sim_sensors.physics.texture_touch import RELIEF_PER_M, VISCOUS_S, compliance_share
from studies.observer.texture_observer import PATTERN, Features
from studies.touches.stroke_path import FORCE_N, SPEED_M_S
from teletaction.testbed.rendered_fingers import TICK_S

Array = NDArray[np.float64]

FLOOR_RAD_S = MOTOR_FLOOR_RPM / RPM_PER_RAD_S
"""Lowest motor speed that a finger feels, rad/s."""
LEAST_RISE = math.log(1.32)
"""Least prominence of a groove's peak in ln(speed squared): an amplitude threshold of 32 %."""
FEWEST_GROOVES = 3
IRREGULARITY_UNIT = 0.14
"""Relative difference of two spatial periods that is just distinguished; unit of the distances' relative spread."""
Typical = Callable[[Array], np.float64]
"""Typical value over a stroke: `np.mean`, or `np.median` for the surface between the grooves."""


def motor_features(speed_rad_s: Array, *, stroke_m_s: float = SPEED_M_S, typical: Typical = np.mean) -> Features:
    """Return the features of a motor's course during a steady stroke, one speed each tick.

    The motor's mass shakes the finger with an acceleration proportional to the square of its speed. The weakest felt
    acceleration is added, as in Weber's law near threshold, so that standstill has a finite value.
    """
    intensity = math.log(float(typical(speed_rad_s**2)) + FLOOR_RAD_S**2)
    ln_squares = 2.0 * np.log(np.maximum(speed_rad_s, FLOOR_RAD_S))
    peaks, _ = find_peaks(ln_squares, prominence=LEAST_RISE)
    return _grooved(intensity, stroke_m_s * TICK_S * np.diff(peaks))


def surface_features(
    stiffness_n_m: float,
    profile: SurfaceProfile,
    *,
    stroke_m_s: float = SPEED_M_S,
    typical: Typical = np.mean,
) -> Features:
    """Return the features of a real surface: force fluctuation at a texture sensor's tip, and grooves."""
    rises = profile.height_m[0] + VISCOUS_S * stroke_m_s * profile.slope[0]
    force_n = FORCE_N * RELIEF_PER_M * compliance_share(stiffness_n_m) * rises
    intensity = math.log(float(typical(np.abs(force_n - np.median(force_n)))))
    return _grooved(intensity, np.diff(profile.grooves_m))


def _grooved(ln_intensity: float, distances_m: Array) -> Features:
    if len(distances_m) < FEWEST_GROOVES:
        return Features(ln_intensity)
    mean_m = float(np.mean(distances_m))
    spread = float(np.std(distances_m)) / mean_m
    return Features(ln_intensity, PATTERN, math.log(1e3 * mean_m), spread / IRREGULARITY_UNIT)
