"""Estimates the roughness of a surface: the power of the curvature under a stroke, without grooves and noise.

Eq. 5-6 of Kron & Schmidt 2003 average the rectified signal over the whole stroke and hold the mean within patterns. A
plain average never forgets, and a hold that compares with the held mean never ends on a rougher surface. This estimator
has neither. It leaves out single cells near an impulse, forgets with distance, and restarts the mean at an abrupt
change of surface.
"""

import math
from collections import deque
from itertools import islice
from typing import NamedTuple

from remote_site.texture.tip_path import CELL_M

FORGET_M = 15e-3
"""Distance constant with which the mean forgets a surface, m."""
FREEDOMS_PER_M = 3500.0
"""Number of independent values of the curvature per length of path, 1/m."""
NEAR_M = 0.6e-3
"""Distance from a groove's centre within which the curvature belongs to the groove, m."""
_LATE = round(1.1e-3 / CELL_M)
"""Number of cells held back until no groove can be found there; a groove is found up to 0.5 mm behind it."""
LEAST = round(2e-3 / CELL_M)
"""Minimum number of cells for a valid roughness."""
JUMP_M = 5e-3
"""Length of the recent path whose power is compared with that before, m."""
JUMP = 2.0
"""Difference in ln(power) that shows a change of surface: 5 standard deviations of its random scatter."""
_NEW = round(JUMP_M / CELL_M)
_WATCH = 5
"""Number of cells between two tests for a change of surface."""


class PathCell(NamedTuple):
    """One cell: its place, m; power of the curvature for one newton, V^2; power that noise adds to it, V^2."""

    place_m: float
    power: float
    noise: float


class Roughness:
    """Roughness along the path, cell by cell.

    Attributes:
        changed: whether the last step restarted the mean on another surface.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Forget the surface."""
        self.changed = False
        self._count = 0
        self._power = self._noise = 0.0
        self._new: deque[PathCell] = deque()
        self._new_power = self._new_noise = 0.0
        self.interrupt()

    def interrupt(self) -> None:
        """Interrupt the path."""
        self._late: deque[PathCell] = deque()
        self._groove_m: float | None = None

    @property
    def valid(self) -> bool:
        """Whether the path is long enough for a roughness."""
        return self._count + len(self._new) >= LEAST

    @property
    def roughness_v(self) -> float:
        """Rms curvature for one newton without noise, V; at least about a third of the noise's rms."""
        power, noise = self._mean()
        return math.sqrt(max(power - noise, 0.1 * noise))

    @property
    def roughness_sd_v(self) -> float:
        """Standard deviation of the roughness due to random sampling, V; it excludes the sensor's calibration."""
        power, _ = self._mean()
        way_m = min((self._count + len(self._new)) * CELL_M, 2.0 * FORGET_M)
        freedoms = FREEDOMS_PER_M * max(way_m, CELL_M)
        return 0.5 * power * math.sqrt(2.0 / freedoms) / max(self.roughness_v, 1e-6)

    def _mean(self) -> tuple[float, float]:
        """Return the power, and the power that noise adds to it, V^2."""
        power, noise = self._power, self._noise
        if self._new:  # the recent cells are weighted by the length of their path
            cells = len(self._new)
            part = 1.0 - math.exp(-cells * CELL_M / FORGET_M) if self._count else 1.0
            power += part * (self._new_power / cells - power)
            noise += part * (self._new_noise / cells - noise)
        return power, noise

    def groove(self, place_m: float) -> None:
        """Take a groove at this place, m; the cells near it are left out."""
        self._groove_m = place_m
        self._late = deque(cell for cell in self._late if abs(cell.place_m - place_m) > NEAR_M)

    def step(self, cell: PathCell) -> PathCell | None:
        """Take the next cell; return the cell that now counts for the surface itself."""
        self.changed = False
        if self._groove_m is None:
            self._groove_m = cell.place_m  # a groove may lie just before the path
        if cell.place_m - self._groove_m > NEAR_M:
            self._late.append(cell)
        if not self._late or cell.place_m - self._late[0].place_m < _LATE * CELL_M:
            return None
        settled = self._late.popleft()
        self._new.append(settled)
        self._new_power += settled.power
        self._new_noise += settled.noise
        if len(self._new) > _NEW:
            old = self._new.popleft()
            self._new_power -= old.power
            self._new_noise -= old.noise
            self._average(old)
            if self._count >= LEAST and self._count % _WATCH == 0:
                self._watch_for_a_jump()
        return settled

    def _average(self, cell: PathCell) -> None:
        """Update the mean with forgetting; the first cells form a plain mean."""
        self._count += 1
        part = max(1.0 / self._count, 1.0 - math.exp(-CELL_M / FORGET_M))
        self._power += part * (cell.power - self._power)
        self._noise += part * (cell.noise - self._noise)

    def _watch_for_a_jump(self) -> None:
        self._new_power = sum(cell.power for cell in self._new)  # removes the rounding errors of the running sum
        self._new_noise = sum(cell.noise for cell in self._new)
        if abs(math.log(max(self._new_power / _NEW, 1e-12) / max(self._power, 1e-12))) > JUMP:
            # the path on which the power changed holds both surfaces: only its end belongs to the new one
            self.changed = True
            self._new = deque(islice(self._new, _NEW - _WATCH, None))
            self._new_power = sum(cell.power for cell in self._new)
            self._new_noise = sum(cell.noise for cell in self._new)
            self._count = 0
            self._power = self._noise = 0.0
