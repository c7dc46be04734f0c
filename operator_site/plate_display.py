"""What the plate under each fingertip must show (second stage of Kron & Schmidt 2003, Fig. 5).

The second model of the paper is the same skin on the aluminium plate. Equal flux into an equal skin gives an equal
felt temperature, so nothing has to be inverted: the plate sits where the scene's flux would cross its own contact.
"""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from common.limits import PLATE_COOLING_K_S, PLATE_HEATING_K_S, PlateRange
from operator_site.gate import RATE_ROUNDING_K, Limit
from operator_site.scene_skin import SkinState
from operator_site.tissue import Floats

PLATE_CONTACT_M2K_W = 5.4e-4
"""Contact resistance between finger and aluminium plate."""
NOTHING_AHEAD: Mapping[int, float] = MappingProxyType({})


class PlateDisplay:
    """Set-points of all plates, kept inside what a plate may and can do."""

    def __init__(self, profile: PlateRange, neutral_c: Floats) -> None:
        """Start at `neutral_c` (n,), the skin's own surface temperatures."""
        self._profile = profile
        self._wanted_c = self._inside(neutral_c)
        self._outside = np.zeros(len(self._wanted_c), dtype=np.int64)
        self.set_c = self._wanted_c.copy()
        """Present set-points (n,), C."""
        self.limited: NDArray[np.int64] = self._outside.copy()
        """`Limit` bits (n,): where the plate cannot show what the model wants."""
        self._surface_c, self._flux_w_m2 = neutral_c, np.zeros(len(neutral_c))

    def aim(self, skin: SkinState, touching: Sequence[bool], ahead_c: Mapping[int, float] = NOTHING_AHEAD) -> None:
        """Take what the plates should show; a finger that touches nothing is shown its own skin, no flux.

        Args:
            skin: of the scene.
            touching: which fingers do.
            ahead_c: by finger that is about to touch, what it will meet: its plate goes there already.
        """
        self._flux_w_m2 = np.asarray(touching) * skin.flux_w_m2
        self._surface_c = skin.surface_c
        wanted = skin.surface_c + self._flux_w_m2 * PLATE_CONTACT_M2K_W
        for finger, goal_c in ahead_c.items():
            wanted[finger] = goal_c
        self._wanted_c = self._inside(wanted)
        self._outside = (self._wanted_c != wanted) * Limit.PLATE_RANGE.value

    def step(self, dt_s: float) -> Floats:
        """Set-points (n,), C, `dt_s` later, at no more than the plates' own rates."""
        change = self._wanted_c - self.set_c
        slow = np.minimum(np.maximum(change, -PLATE_COOLING_K_S * dt_s), PLATE_HEATING_K_S * dt_s)
        self.set_c = self.set_c + slow
        behind = (np.abs(change - slow) > RATE_ROUNDING_K) * Limit.PLATE_RATE.value
        self.limited = self._outside | behind
        return self.set_c

    def load_w_m2(self) -> Floats:
        """What fingers take from their plates (n,), W/m2: the scene's flux, as far as the plates' range allows it."""
        possible = (self._wanted_c - self._surface_c) / PLATE_CONTACT_M2K_W
        return np.asarray(np.clip(possible, np.minimum(self._flux_w_m2, 0.0), np.maximum(self._flux_w_m2, 0.0)))

    def needs_s(self, finger: int, goal_c: float) -> float:
        """How long a plate takes to a goal, s."""
        change = goal_c - float(self.set_c[finger])
        return change / PLATE_HEATING_K_S if change > 0.0 else -change / PLATE_COOLING_K_S

    def restart(self, finger: int, plate_c: float) -> None:
        """Go on from where a plate is; without a reading (NaN) it keeps its set-point."""
        if math.isfinite(plate_c):
            self.set_c[finger] = min(self._profile.high_c, max(self._profile.low_c, plate_c))

    def _inside(self, value_c: Floats) -> Floats:
        return np.asarray(np.minimum(np.maximum(value_c, self._profile.low_c), self._profile.high_c))
