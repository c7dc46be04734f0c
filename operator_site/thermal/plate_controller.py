"""Controls the temperature of one fingertip plate with feedforward of the required heat plus PI.

The controller works in K/s of the plate. The scene gives the finger's heat flux, so it is fed forward instead of being
corrected from the error.
"""

import math

from common.limits import PLATE_COOLING_K_S, PLATE_HEATING_K_S

PROPORTIONAL_PER_S = 3.0
"""Proportional gain, 1/s."""
INTEGRAL_PER_S2 = 1.0
"""Integral gain, 1/s^2."""
NTC_LAG_S = 0.08
"""Time constant of the thermistor's lag behind its plate, s."""
PLATE_HEAT_J_M2K = 2000.0
"""Heat capacity of the plate with soldered parts per finger area, J/(m2 K): 0.3 J/K on 10 x 15 mm."""

_PELTIER_K_S = 0.5 * (PLATE_HEATING_K_S + PLATE_COOLING_K_S)
"""Rate of the plate by the Peltier effect at drive 1, K/s; it is proportional to the drive u."""
_JOULE_K_S = 0.5 * (PLATE_HEATING_K_S - PLATE_COOLING_K_S)
"""Rate of the plate by Joule heating at drive 1, K/s; it is proportional to u^2 and adds to the Peltier effect."""


class PlateController:
    """Controller of one plate; the gate limits its output before the device."""

    def __init__(self) -> None:
        self._t_s = math.nan
        self._set_c = math.nan
        self._expected_c = math.nan
        self._integral_k_s = 0.0

    def reset(self) -> None:
        """Reset the controller of a plate that was not driven meanwhile."""
        self._t_s = math.nan
        self._integral_k_s = 0.0

    def step(self, t_s: float, set_c: float, plate_c: float, load_w_m2: float = 0.0) -> float:
        """Return the Peltier drive -1..1 (positive heats) for a new reading; 0 without one.

        Args:
            t_s: time of the reading, s.
            set_c: set-point, C, already limited in rate.
            plate_c: the reading, C; NaN if the sensor is invalid.
            load_w_m2: heat flux from the plate into the finger, W/m2.
        """
        if not math.isfinite(set_c + plate_c + load_w_m2):
            self.reset()
            return 0.0
        dt_s = t_s - self._t_s
        load_k_s = load_w_m2 / PLATE_HEAT_J_M2K
        if not 0.0 < dt_s <= 0.1:  # first reading, or after a silence: no feedforward
            self._t_s, self._set_c, self._expected_c = t_s, set_c, set_c
            self._integral_k_s = 0.0
            return _drive(PROPORTIONAL_PER_S * (set_c - plate_c))[0]
        ahead_k_s = (set_c - self._set_c) / dt_s + load_k_s
        self._t_s, self._set_c = t_s, set_c
        # Compare the reading with that of a lagging sensor on a plate at the set-point.
        self._expected_c += (set_c - self._expected_c) * dt_s / (NTC_LAG_S + dt_s)
        error = self._expected_c - plate_c
        wanted = ahead_k_s + PROPORTIONAL_PER_S * error + self._integral_k_s
        drive, possible = _drive(wanted)
        if possible == wanted or (wanted > possible) != (error > 0.0):
            self._integral_k_s += INTEGRAL_PER_S2 * error * dt_s  # anti-windup: hold at saturation
        return drive


def _drive(rate_k_s: float) -> tuple[float, float]:
    """Return the drive for a wanted rate, and the rate within the plate's limits, K/s."""
    possible = min(PLATE_HEATING_K_S, max(-PLATE_COOLING_K_S, rate_k_s))
    root = math.sqrt(_PELTIER_K_S**2 + 4.0 * _JOULE_K_S * possible)
    return min(1.0, max(-1.0, 0.5 * (root - _PELTIER_K_S) / _JOULE_K_S)), possible
