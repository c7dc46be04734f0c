"""Build the set-points of a commanded hand over time: along the bench and in height, with slips and shaking arms.

Movements are minimum-jerk (Flash & Hogan 1985). A stroke starts and stops with minimum jerk and has constant speed in
between.
"""

import math
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from sim_sensors.operator_hand.hand_plan import RAMP_S

TICK_S = 0.002
UP_M = 0.006
SHAKE_S = 0.06
Array = NDArray[np.float64]


def times_s(ticks: int) -> Array:
    """Return the end times of `ticks` ticks, s."""
    return TICK_S * np.arange(1, ticks + 1, dtype=np.float64)


def eased(u: Array) -> Array:
    """Return the fraction of a minimum-jerk movement's path after the fraction `u` of its time."""
    u = np.clip(u, 0.0, 1.0)
    way: Array = u * u * u * (10.0 + u * (6.0 * u - 15.0))
    return way


class CommandedHand:
    """Builder of set-points, piece by piece; every piece begins where the last one ended.

    Attributes:
        along_m: last commanded position along the stroke's direction, m.
        z_m: last commanded height of the fingertip, m.
    """

    def __init__(self) -> None:
        self.along_m = 0.0
        self.z_m = UP_M
        self._pieces: dict[str, list[Array]] = defaultdict(list)

    def stay(self, seconds: float) -> None:
        """Hold the present set-points."""
        self._add(_ticks(seconds))

    def height(self, z_m: float, seconds: float, *, along_speed_m_s: float = 0.0) -> None:
        """Move the finger to a height while the hand moves at constant speed."""
        ticks = _ticks(seconds)
        rising = self.z_m + (z_m - self.z_m) * eased(np.arange(1, ticks + 1) / ticks)
        self._add(ticks, z_m=rising, along_m=self._on(ticks, along_speed_m_s))

    def sway(self, amplitude_m: float, hz: float, seconds: float, *, along_speed_m_s: float = 0.0) -> None:
        """Vary the height by a sine over whole periods while the hand moves at constant speed."""
        ticks = _ticks(seconds)
        turns = max(1.0, round(hz * seconds)) * np.arange(1, ticks + 1) / ticks
        swaying = self.z_m + amplitude_m * np.sin(2.0 * math.pi * turns)
        self._add(ticks, z_m=swaying, along_m=self._on(ticks, along_speed_m_s))

    def go(self, speed_m_s: float, seconds: float) -> None:
        """Move at constant speed, without acceleration at start and end."""
        ticks = _ticks(seconds)
        self._add(ticks, along_m=self._on(ticks, speed_m_s))

    def change_speed(self, from_m_s: float, to_m_s: float, seconds: float = RAMP_S) -> None:
        """Accelerate, slow down or turn with minimum jerk."""
        ticks = _ticks(seconds)
        speed = from_m_s + (to_m_s - from_m_s) * eased((np.arange(ticks) + 0.5) / ticks)
        self._add(ticks, along_m=self.along_m + TICK_S * np.cumsum(speed))

    def stroke(self, distance_m: float, speed_m_s: float) -> None:
        """Move by a distance of either sign, from rest to rest."""
        speed = math.copysign(speed_m_s, distance_m)
        self.change_speed(0.0, speed)
        self.go(speed, max(0.0, abs(distance_m) / speed_m_s - RAMP_S))
        self.change_speed(speed, 0.0)

    def slip(self, distance_m: float, seconds: float) -> None:
        """Hold the set-points while the finger slips along."""
        ticks = _ticks(seconds)
        self._add(ticks, slipped_m=distance_m * eased(np.arange(1, ticks + 1) / ticks))

    def shake(self, amplitude_m: float, hz: float, seconds: float) -> None:
        """Hold the set-points while the arm shakes; the shaking rises and falls within SHAKE_S."""
        ticks = _ticks(seconds)
        time_s = times_s(ticks)
        strength = np.minimum(eased(time_s / SHAKE_S), eased((time_s[-1] - time_s) / SHAKE_S))
        self._add(ticks, shaken_m=amplitude_m * strength * np.sin(2.0 * math.pi * hz * time_s))

    def course(self) -> dict[str, Array]:
        """Return all set-points so far, one a tick: `along_m`, `z_m`, `slipped_m` (since the start) and `shaken_m`."""
        return {name: np.concatenate(pieces) for name, pieces in self._pieces.items()}

    def _on(self, ticks: int, speed_m_s: float) -> Array:
        return self.along_m + speed_m_s * times_s(ticks)

    def _add(
        self,
        ticks: int,
        *,
        along_m: Array | None = None,
        z_m: Array | None = None,
        slipped_m: Array | None = None,
        shaken_m: Array | None = None,
    ) -> None:
        if not ticks:
            return
        before = self._pieces["slipped_m"][-1][-1] if self._pieces["slipped_m"] else 0.0
        still = np.zeros(ticks)
        self._pieces["along_m"].append(still + self.along_m if along_m is None else along_m)
        self._pieces["z_m"].append(still + self.z_m if z_m is None else z_m)
        self._pieces["slipped_m"].append(before + (still if slipped_m is None else slipped_m))
        self._pieces["shaken_m"].append(still if shaken_m is None else shaken_m)
        self.along_m = float(self._pieces["along_m"][-1][-1])
        self.z_m = float(self._pieces["z_m"][-1][-1])


def _ticks(seconds: float) -> int:
    return round(seconds / TICK_S)
