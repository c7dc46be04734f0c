"""Computes set-point and drive of the plate under each fingertip (second stage of Kron & Schmidt 2003, Fig. 5).

The second model of the paper is the same skin on the aluminium plate. Equal flux into an equal skin gives an equal felt
temperature, so no model is inverted. The set-point is the plate temperature that drives the scene's flux through the
plate's contact resistance.

The controller of a plate works in K/s. It feeds forward the scene's heat flux, and corrects the error with PI.
"""

import math
from collections.abc import Mapping, Sequence

from common.limits import PLATE_COOLING_K_S, PLATE_HEATING_K_S, PlateRange
from operator_site.safety.limit_flags import RATE_ROUNDING_K, Limit
from operator_site.thermal.scene_skin import SkinState

PLATE_CONTACT_M2K_W = 5.4e-4
"""Contact resistance between finger and aluminium plate, m2K/W."""
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
_OUTSIDE, _BEHIND = Limit.PLATE_RANGE.value, Limit.PLATE_RATE.value


class PlateSetpoint:
    """Set-points of all plates within their range and rate.

    Attributes:
        set_c: present set-points (n,), C.
        limited: `Limit` bits (n,) of each plate that cannot display the model's output.
    """

    def __init__(self, profile: PlateRange, neutral_c: Sequence[float]) -> None:
        """Start at `neutral_c` (n,), the skin's own surface temperatures, C."""
        self._profile = profile
        self._surface_c = neutral_c
        self._flux_w_m2 = [0.0] * len(self._surface_c)
        self._wanted_c = [self._inside(surface_c) for surface_c in self._surface_c]
        self._outside = [0] * len(self._wanted_c)
        self.set_c = list(self._wanted_c)
        self.limited = list(self._outside)
        self._settled = False
        """Whether all set-points have reached their wanted values."""

    def aim(self, skin: SkinState, touching: Sequence[bool], ahead_c: Mapping[int, float]) -> None:
        """Set the wanted temperatures; the plate of a free finger gets the skin's own temperature, without flux.

        Args:
            skin: state of the skin in the scene.
            touching: whether each finger touches.
            ahead_c: expected contact temperature of each finger about to touch, C; its plate goes there at once.
        """
        self._settled = False
        self._surface_c, self._flux_w_m2 = skin.surface_c, list(skin.flux_w_m2)
        for finger, surface_c in enumerate(self._surface_c):
            if not touching[finger]:
                self._flux_w_m2[finger] = 0.0
            flux_w_m2 = self._flux_w_m2[finger]
            wanted_c = ahead_c[finger] if finger in ahead_c else surface_c + flux_w_m2 * PLATE_CONTACT_M2K_W
            self._wanted_c[finger] = possible_c = self._inside(wanted_c)
            self._outside[finger] = _OUTSIDE if possible_c != wanted_c else 0

    def step(self, dt_s: float) -> list[float]:
        """Return the set-points (n,), C, `dt_s` later, at no more than the plates' rates."""
        if self._settled:
            return list(self.set_c)
        lowest_k, highest_k = -PLATE_COOLING_K_S * dt_s, PLATE_HEATING_K_S * dt_s
        self.limited = list(self._outside)
        for finger, wanted_c in enumerate(self._wanted_c):
            change_k = wanted_c - self.set_c[finger]
            if not lowest_k <= change_k <= highest_k:
                slow_k = min(max(change_k, lowest_k), highest_k)  # in this order NaN stays NaN
                if abs(change_k - slow_k) > RATE_ROUNDING_K:
                    self.limited[finger] |= _BEHIND
                change_k = slow_k
            self.set_c[finger] += change_k
        self._settled = self.set_c == self._wanted_c
        return list(self.set_c)

    def load_w_m2(self) -> list[float]:
        """Return the flux from the plates into the fingers (n,), W/m2: the scene's flux within the plates' range."""
        found = []
        for wanted_c, surface_c, flux_w_m2 in zip(self._wanted_c, self._surface_c, self._flux_w_m2, strict=True):
            possible_w_m2 = (wanted_c - surface_c) / PLATE_CONTACT_M2K_W
            found.append(min(max(possible_w_m2, min(flux_w_m2, 0.0)), max(flux_w_m2, 0.0)))
        return found

    def needs_s(self, finger: int, goal_c: float) -> float:
        """Return the time that a plate needs to reach a temperature, s."""
        change = goal_c - self.set_c[finger]
        return change / PLATE_HEATING_K_S if change > 0.0 else -change / PLATE_COOLING_K_S

    def restart(self, finger: int, plate_c: float) -> None:
        """Continue from the plate's temperature; without a reading (NaN) the set-point stays."""
        self._settled = False
        if math.isfinite(plate_c):
            self.set_c[finger] = self._inside(plate_c)

    def _inside(self, value_c: float) -> float:
        return min(max(value_c, self._profile.low_c), self._profile.high_c)


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
