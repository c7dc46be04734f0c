"""Detects a plate that does not follow its drive: a dead, stuck or detached sensor, a dead heater, reversed polarity.

Drive and reading pass the same band-pass filter, on both sides of the plate's heat balance. The filter removes the
drive that only holds a temperature against a steady loss. The rest of the drive must appear in the reading.

A plate that runs away from a steady hold does so under a nearly constant drive, which no band-pass filter shows.
Therefore a second test compares the recent change of the plate with its recent drive: they must not be opposite.
A third test, in `plate_load`, finds a sensor that comes off slowly.
"""

from common.faults.fault import FaultCode
from common.limits import DOSE_ABOVE_C, PLATE_COOLING_K_S, PLATE_HEATING_K_S
from operator_site.safety.plate_load import PlateLoad

CHECK_S = 0.01
"""Interval between two checks of a plate, s."""
LAG_S = 0.2
"""Time constant of the lag from drive to reading, s."""
SLOW_S = 1.0
"""Time constant of the band-pass filter, s."""
EXPECTED_HEATING_K = 1.0
"""Minimum expected change by heating that is tested, K; full drive passes 1.3 K."""
EXPECTED_COOLING_K = 0.8
"""Minimum expected change by cooling that is tested, K; full drive passes 0.9 K."""
LEAST_SHARE = 0.2
"""Minimum share of the expected change that a sound reading shows."""
PERSIST_S = 0.05
"""Time for which the share may be smaller, s."""
AGAINST_S = 0.5
"""Time constant of the memory of recent drive and recent change, s."""
AGAINST_K = 1.0
"""Recent drive of a plate, and recent change in the opposite direction, that are a fault together, K.

Normal use makes up to 0.63 K of both, when a plate changes its direction or its finger warms it, with a reading that is
0.1 s late and has 0.1 K of noise.
"""
STILL_K = 0.01
"""Largest change of a reading that counts as none, K; less than half a count."""
STILL_S = 0.5
"""Duration of an unchanged reading before an expected change is missed, s."""
STILL_EXPECTED_K = 0.3
"""Expected change that an unchanged reading may miss, K."""
STILL_DRIVEN_K = 0.5
"""Change by a changing drive that an unchanged reading may miss, K.

A constant drive holds a constant temperature. So only the drive beyond its range at the last change counts.
"""
STILL_MEMORY_S = 3.0
"""Time constant with which that change is forgotten, s."""
STILL_HEATED_S = 3.0
"""Longest time of a heating drive without a change of the reading, s.

As its finger warms, a plate becomes hotter under a constant drive, and a sound converter has noise of half a count.
"""
STILL_HOT_S = 1.0
"""Longest unchanged reading at a temperature at which skin takes dose, s."""


class _Band:
    """Band-pass of a rate, K/s in, K out."""

    def __init__(self) -> None:
        self.mean_k_s = 0.0
        self.change_k = 0.0

    def step(self, dt_s: float, rate_k_s: float) -> None:
        self.mean_k_s += (rate_k_s - self.mean_k_s) * dt_s / (SLOW_S + dt_s)
        self.change_k += (rate_k_s - self.mean_k_s - self.change_k / SLOW_S) * dt_s


class _Recent:
    """Recent change by a rate, K/s in, K out."""

    def __init__(self) -> None:
        self.change_k = 0.0

    def step(self, dt_s: float, rate_k_s: float) -> float:
        self.change_k += (rate_k_s - self.change_k / AGAINST_S) * dt_s
        return self.change_k


class PlateFollowing:
    """Watches one plate; call `step` about every CHECK_S."""

    def __init__(self) -> None:
        self._drive_k_s = 0.0
        self._expected = _Band()
        self._seen = _Band()
        self._driven = _Recent()
        self._moved = _Recent()
        self._load = PlateLoad()
        self._plate_c: float | None = None
        self._doubt_s = 0.0
        self._still_c = 0.0
        self._still_s = 0.0
        self._still_heated_s = 0.0
        self._holding_k_s = (0.0, 0.0)
        self._held_k = 0.0
        self.rate_k_s = 0.0
        """Smoothed rate of change of the reading, K/s."""

    @property
    def started(self) -> bool:
        """Whether any reading was given."""
        return self._plate_c is not None

    def step(self, dt_s: float, drive: float, plate_c: float) -> FaultCode | None:
        """Return the fault of the plate; None without one.

        Args:
            dt_s: time since the last call, s.
            drive: Peltier drive in this time, -1..1.
            plate_c: present reading, C, finite.
        """
        if self._plate_c is None:
            self._plate_c = self._still_c = plate_c
            return None
        rate = (plate_c - self._plate_c) / dt_s
        self._plate_c = plate_c
        self.rate_k_s += (rate - self.rate_k_s) * dt_s / (0.1 + dt_s)
        power = drive * (PLATE_HEATING_K_S if drive > 0.0 else PLATE_COOLING_K_S)
        self._drive_k_s += (power - self._drive_k_s) * dt_s / (LAG_S + dt_s)
        self._expected.step(dt_s, self._drive_k_s)
        self._seen.step(dt_s, rate)
        expected, seen = self._expected.change_k, self._seen.change_k
        takes_heat = self._load.step(dt_s, power, rate, plate_c)
        driven, moved = self._driven.step(dt_s, self._drive_k_s), self._moved.step(dt_s, rate)
        if max(min(driven, -moved), min(-driven, moved)) >= AGAINST_K:
            return FaultCode.PLATE_AGAINST_DRIVE

        if abs(plate_c - self._still_c) > STILL_K:
            self._still_c, self._still_s, self._still_heated_s = plate_c, 0.0, 0.0
            # A change of the count moves the drive, and the mean follows later; the range between both is normal.
            mean, now = self._expected.mean_k_s, self._drive_k_s
            self._holding_k_s, self._held_k = (min(mean, now), max(mean, now)), 0.0
        else:
            self._still_s += dt_s
            self._still_heated_s += dt_s if self._drive_k_s > 0.0 else 0.0
            low, high = self._holding_k_s
            beyond = self._drive_k_s - min(high, max(low, self._drive_k_s))
            self._held_k += (beyond - self._held_k / STILL_MEMORY_S) * dt_s
        if self._still_s >= STILL_S and abs(expected - seen) >= STILL_EXPECTED_K:
            return FaultCode.PLATE_UNMOVED
        if abs(self._held_k) >= STILL_DRIVEN_K:
            return FaultCode.PLATE_STILL_DRIVEN
        if self._still_s >= STILL_HOT_S and plate_c > DOSE_ABOVE_C:
            return FaultCode.PLATE_STILL_HOT
        if self._still_heated_s >= STILL_HEATED_S and self._drive_k_s > 0.0:
            return FaultCode.PLATE_STILL_HEATED

        enough = EXPECTED_HEATING_K
        if expected < 0.0:
            expected, seen, enough = -expected, -seen, EXPECTED_COOLING_K
        if expected >= enough and seen < LEAST_SHARE * expected:
            self._doubt_s += dt_s
        else:
            self._doubt_s = 0.0
        if self._doubt_s >= PERSIST_S:
            return FaultCode.PLATE_NOT_FOLLOWING
        return FaultCode.PLATE_TAKES_HEAT if takes_heat else None
