"""Does a plate follow its drive? Finds a dead, stuck or detached sensor, a dead heater, reversed polarity.

Drive and reading pass the same band-pass (both sides of the plate's heat balance), which removes what
holds a temperature against a steady loss. What is left of the drive must be found again in the reading.

A plate that runs away from a steady hold does so under a drive that hardly changes, and that no band-pass shows. So
what a plate did lately must also not be the opposite of what it was driven to lately.
"""

from common.faults.fault import FaultCode
from common.limits import DOSE_ABOVE_C, PLATE_COOLING_K_S, PLATE_HEATING_K_S

CHECK_S = 0.01
LAG_S = 0.2
SLOW_S = 1.0
EXPECTED_HEATING_K = 1.0
EXPECTED_COOLING_K = 0.8
"""A change this large that the drive should have made, and ... (full drive passes 1.3 K and 0.9 K)"""
LEAST_SHARE = 0.2
"""... of which less than this share is seen, for ..."""
PERSIST_S = 0.05
AGAINST_S = 0.5
AGAINST_K = 1.0
"""Within about so long the plate was driven by so much one way, and went as far the other. Normal use, with a reading
0.1 s late and 0.1 K of noise, makes 0.63 K of both at once: a plate that turns, or that its finger warms."""
STILL_K = 0.01
"""Less than half a count: a reading that does not move by more is the same reading."""
STILL_S = 0.5
STILL_EXPECTED_K = 0.3
"""A reading that is still for so long may miss so much of the expected change, no more."""
STILL_DRIVEN_K = 0.5
STILL_MEMORY_S = 3.0
"""A drive that goes on changing under a reading that does not move: the plate would have moved by so much. An even
drive holds an even temperature: only what differs from the drive before counts, and is forgotten in time."""
STILL_HEATED_S = 3.0
"""Under a drive that heats, a reading is not believed that never moves for so long: as its finger warms, a plate gets
hotter under a drive that does not change at all, and a sound converter's reading has noise of half a count."""
STILL_HOT_S = 1.0
"""Where skin takes dose, a reading that never moves is not believed for longer, whatever the drive."""


class _Band:
    """Band-pass of a rate, K/s in, K out."""

    __slots__ = ("change_k", "mean_k_s")

    def __init__(self) -> None:
        self.mean_k_s = 0.0
        self.change_k = 0.0

    def step(self, dt_s: float, rate_k_s: float) -> None:
        self.mean_k_s += (rate_k_s - self.mean_k_s) * dt_s / (SLOW_S + dt_s)
        self.change_k += (rate_k_s - self.mean_k_s - self.change_k / SLOW_S) * dt_s


class _Recent:
    """What a rate has made of late, K/s in, K out."""

    __slots__ = ("change_k",)

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
        self._plate_c: float | None = None
        self._doubt_s = 0.0
        self._still_c = 0.0
        self._still_s = 0.0
        self._holding_k_s = (0.0, 0.0)
        self._held_k = 0.0
        self.rate_k_s = 0.0
        """Smoothed rate of change of the reading, K/s."""

    @property
    def started(self) -> bool:
        """Whether any reading was given."""
        return self._plate_c is not None

    def step(self, dt_s: float, drive: float, plate_c: float) -> FaultCode | None:
        """Return what is wrong, or None.

        Args:
            dt_s: time since the last call, s.
            drive: Peltier drive that was applied during it, -1..1.
            plate_c: the reading now, C, finite.
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
        driven, moved = self._driven.step(dt_s, self._drive_k_s), self._moved.step(dt_s, rate)
        if max(min(driven, -moved), min(-driven, moved)) >= AGAINST_K:
            return FaultCode.PLATE_AGAINST_DRIVE

        if abs(plate_c - self._still_c) > STILL_K:
            self._still_c, self._still_s = plate_c, 0.0
            # A count that flips kicks the drive, and after a change the mean is behind it: the range of both is normal.
            mean, now = self._expected.mean_k_s, self._drive_k_s
            self._holding_k_s, self._held_k = (min(mean, now), max(mean, now)), 0.0
        else:
            self._still_s += dt_s
            low, high = self._holding_k_s
            beyond = self._drive_k_s - min(high, max(low, self._drive_k_s))
            self._held_k += (beyond - self._held_k / STILL_MEMORY_S) * dt_s
        if self._still_s >= STILL_S and abs(expected - seen) >= STILL_EXPECTED_K:
            return FaultCode.PLATE_UNMOVED
        if abs(self._held_k) >= STILL_DRIVEN_K:
            return FaultCode.PLATE_STILL_DRIVEN
        if self._still_s >= STILL_HOT_S and plate_c > DOSE_ABOVE_C:
            return FaultCode.PLATE_STILL_HOT
        if self._still_s >= STILL_HEATED_S and self._drive_k_s > 0.0:
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
        return None
