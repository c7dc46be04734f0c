"""Temperature loop of one fingertip plate: the heat that its set-point needs fed forward, plus PI.

Works in K/s of plate. What the finger takes or gives is known from the scene, so it need not be found by the error.
"""

import math

from common.limits import PLATE_COOLING_K_S, PLATE_HEATING_K_S

PROPORTIONAL_PER_S = 3.0
INTEGRAL_PER_S2 = 1.0
NTC_LAG_S = 0.08
"""How far the thermistor is behind its plate."""
PLATE_HEAT_J_M2K = 2000.0
"""Heat capacity of the plate and what is soldered to it, for each area of finger: 0.3 J/K on 10 x 15 mm."""

_PELTIER_K_S = 0.5 * (PLATE_HEATING_K_S + PLATE_COOLING_K_S)
_JOULE_K_S = 0.5 * (PLATE_HEATING_K_S - PLATE_COOLING_K_S)
"""A drive u moves heat in proportion to u, and heats both sides with u^2: the plate changes by the sum of both."""


class PlateController:
    """One plate's controller; the gate decides afterwards what reaches the device."""

    def __init__(self) -> None:
        self._t_s = math.nan
        self._set_c = math.nan
        self._expected_c = math.nan
        self._integral_k_s = 0.0

    def reset(self) -> None:
        """Forget everything: for a plate that was not driven meanwhile."""
        self._t_s = math.nan
        self._integral_k_s = 0.0

    def step(self, t_s: float, set_c: float, plate_c: float, load_w_m2: float = 0.0) -> float:
        """Peltier drive -1..1 (positive heats) for a new reading; 0 where there is none.

        Args:
            t_s: time of the reading, s.
            set_c: set-point, C, already limited in rate.
            plate_c: the reading, C; NaN when the sensor is not to be believed.
            load_w_m2: what the finger takes from the plate, W/m2.
        """
        if not math.isfinite(set_c + plate_c + load_w_m2):
            self.reset()
            return 0.0
        dt_s = t_s - self._t_s
        load_k_s = load_w_m2 / PLATE_HEAT_J_M2K
        if not 0.0 < dt_s <= 0.1:  # first reading, or after a silence: nothing to feed forward
            self._t_s, self._set_c, self._expected_c = t_s, set_c, set_c
            self._integral_k_s = 0.0
            return _drive(PROPORTIONAL_PER_S * (set_c - plate_c))[0]
        ahead_k_s = (set_c - self._set_c) / dt_s + load_k_s
        self._t_s, self._set_c = t_s, set_c
        # Judge the reading against what a lagging sensor would read on a plate that is right.
        self._expected_c += (set_c - self._expected_c) * dt_s / (NTC_LAG_S + dt_s)
        error = self._expected_c - plate_c
        wanted = ahead_k_s + PROPORTIONAL_PER_S * error + self._integral_k_s
        drive, possible = _drive(wanted)
        if possible == wanted or (wanted > possible) != (error > 0.0):
            self._integral_k_s += INTEGRAL_PER_S2 * error * dt_s  # else saturated: winding up helps nobody
        return drive


def _drive(rate_k_s: float) -> tuple[float, float]:
    """Drive for a wanted rate, and the rate that it can give."""
    possible = min(PLATE_HEATING_K_S, max(-PLATE_COOLING_K_S, rate_k_s))
    root = math.sqrt(_PELTIER_K_S**2 + 4.0 * _JOULE_K_S * possible)
    return min(1.0, max(-1.0, 0.5 * (root - _PELTIER_K_S) / _JOULE_K_S)), possible
