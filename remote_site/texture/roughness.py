"""Roughness of a surface: the power of the curvature that a stroke feels, without grooves and without noise.

Eq. 5-6 of Kron & Schmidt 2003 average the rectified signal over the whole stroke and hold the mean within patterns. A
plain average never forgets, and a hold that compares with the held mean never ends on a rougher surface. Here there
is neither: places near an impulse are left out one by one, what was felt is forgotten with the way, and a surface
that differs at once from what was before starts the mean anew.
"""

import math
from collections import deque
from itertools import islice
from typing import NamedTuple

from remote_site.texture.tip_path import CELL_M

FORGET_M = 15e-3
"""Way over which a surface is forgotten, m."""
FREEDOMS_PER_M = 3500.0
"""Independent values of the curvature along the way, 1/m."""
NEAR_M = 0.6e-3
"""Curvature nearer than this to a groove's middle is the groove's, m."""
_LATE = round(1.1e-3 / CELL_M)
"""Cells kept back until it is known that no groove was there: one is found up to 0.5 mm behind it."""
LEAST = round(2e-3 / CELL_M)
"""Cells before the roughness is one."""
JUMP_M = 5e-3
JUMP = 2.0
"""A surface changed when the power over the last JUMP_M differs from that before by this in ln: 5 sd of chance."""
_NEW = round(JUMP_M / CELL_M)
_WATCH = 5
"""Cells from one look for a jump to the next."""


class Felt(NamedTuple):
    """One cell: its place, m; power of the curvature for one newton and what noise adds to it, V^2."""

    place_m: float
    power: float
    noise: float


class Roughness:
    """Roughness along the way, cell by cell.

    Attributes:
        changed: whether the last step started the mean anew on another surface.
    """

    __slots__ = ("_count", "_felt", "_groove_m", "_new", "_new_noise", "_new_power", "_noise", "_power", "changed")

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Another surface."""
        self.changed = False
        self._count = 0
        self._power = self._noise = 0.0
        self._new: deque[Felt] = deque()
        self._new_power = self._new_noise = 0.0
        self.interrupt()

    def interrupt(self) -> None:
        """The way is interrupted."""
        self._felt: deque[Felt] = deque()
        self._groove_m: float | None = None

    @property
    def valid(self) -> bool:
        """Whether enough was felt."""
        return self._count + len(self._new) >= LEAST

    @property
    def roughness_v(self) -> float:
        """Rms curvature for one newton without noise, V; what noise hides is a third of it at most."""
        power, noise = self._mean()
        return math.sqrt(max(power - noise, 0.1 * noise))

    @property
    def roughness_sd_v(self) -> float:
        """Its standard deviation by the chance of what was felt, V; the sensor's own calibration is not in it."""
        power, noise = self._mean()
        way_m = min((self._count + len(self._new)) * CELL_M, 2.0 * FORGET_M)
        freedoms = FREEDOMS_PER_M * max(way_m, CELL_M)
        return 0.5 * power * math.sqrt(2.0 / freedoms) / max(math.sqrt(max(power - noise, 0.1 * noise)), 1e-6)

    def _mean(self) -> tuple[float, float]:
        """Power, and what noise adds to it, V^2."""
        power, noise = self._power, self._noise
        if self._new:  # what is too new to be old is as much of the mean as its way
            cells = len(self._new)
            part = 1.0 - math.exp(-cells * CELL_M / FORGET_M) if self._count else 1.0
            power += part * (self._new_power / cells - power)
            noise += part * (self._new_noise / cells - noise)
        return power, noise

    def groove(self, place_m: float) -> None:
        """A groove was found here: what was felt near it is its own."""
        self._groove_m = place_m
        self._felt = deque(felt for felt in self._felt if abs(felt.place_m - place_m) > NEAR_M)

    def step(self, felt: Felt) -> Felt | None:
        """Take the next cell; return the one that is now known to be of the surface itself."""
        self.changed = False
        if self._groove_m is None:
            self._groove_m = felt.place_m  # for all that is known there was one just before
        if felt.place_m - self._groove_m > NEAR_M:
            self._felt.append(felt)
        if not self._felt or felt.place_m - self._felt[0].place_m < _LATE * CELL_M:
            return None
        settled = self._felt.popleft()
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

    def _average(self, felt: Felt) -> None:
        """Mean with forgetting; a plain one before there is anything to forget."""
        self._count += 1
        part = max(1.0 / self._count, 1.0 - math.exp(-CELL_M / FORGET_M))
        self._power += part * (felt.power - self._power)
        self._noise += part * (felt.noise - self._noise)

    def _watch_for_a_jump(self) -> None:
        self._new_power = sum(felt.power for felt in self._new)  # what rounding has left behind is gone
        self._new_noise = sum(felt.noise for felt in self._new)
        if abs(math.log(max(self._new_power / _NEW, 1e-12) / max(self._power, 1e-12))) > JUMP:
            # the way on which the power changed is of both surfaces: only its end is the new one's
            self.changed = True
            self._new = deque(islice(self._new, _NEW - _WATCH, None))
            self._new_power = sum(felt.power for felt in self._new)
            self._new_noise = sum(felt.noise for felt in self._new)
            self._count = 0
            self._power = self._noise = 0.0
