"""What the plate under each fingertip must show (second stage of Kron & Schmidt 2003, Fig. 5).

The second model of the paper is the same skin on the aluminium plate. Equal flux into an equal skin gives an equal
felt temperature, so nothing has to be inverted: the plate sits where the scene's flux would cross its own contact.
"""

import math
from collections.abc import Sequence

from common.limits import PLATE_COOLING_K_S, PLATE_HEATING_K_S, PlateRange
from operator_site.gate import RATE_ROUNDING_K, Limit
from operator_site.scene_skin import SkinState

PLATE_CONTACT_M2K_W = 5.4e-4
"""Contact resistance between finger and aluminium plate."""


class PlateDisplay:
    """Set-points of all plates, kept inside what a plate may and can do."""

    def __init__(self, profile: PlateRange, neutral_c: Sequence[float]) -> None:
        """Start at `neutral_c`, the skin's own surface temperatures."""
        self._profile = profile
        self._wanted_c = [self._inside(value) for value in neutral_c]
        self._outside = [0] * len(self._wanted_c)
        self.set_c = list(self._wanted_c)
        """Present set-points, C."""
        self.limited = [0] * len(self._wanted_c)
        """`Limit` bits: where the plate cannot show what the model wants."""

    def aim(self, skin: SkinState, touching: Sequence[bool]) -> None:
        """Take what the plates should show; a finger that touches nothing is shown its own skin, no flux."""
        surface, flux = skin.surface_c.tolist(), skin.flux_w_m2.tolist()
        for finger, touches in enumerate(touching):
            wanted = surface[finger] + (flux[finger] * PLATE_CONTACT_M2K_W if touches else 0.0)
            inside = self._inside(wanted)
            self._wanted_c[finger] = inside
            self._outside[finger] = 0 if inside == wanted else Limit.PLATE_RANGE.value

    def step(self, dt_s: float) -> list[float]:
        """Set-points, C, `dt_s` later, at no more than the plates' own rates."""
        up, down = PLATE_HEATING_K_S * dt_s, -PLATE_COOLING_K_S * dt_s
        for finger, wanted in enumerate(self._wanted_c):
            change = wanted - self.set_c[finger]
            slow = min(up, max(down, change))
            self.set_c[finger] += slow
            behind = Limit.PLATE_RATE.value if abs(change - slow) > RATE_ROUNDING_K else 0
            self.limited[finger] = self._outside[finger] | behind
        return list(self.set_c)

    def restart(self, finger: int, plate_c: float) -> None:
        """Go on from where a plate is; without a reading (NaN) it keeps its set-point."""
        if math.isfinite(plate_c):
            self.set_c[finger] = self._inside(plate_c)

    def _inside(self, value_c: float) -> float:
        return min(self._profile.high_c, max(self._profile.low_c, value_c))
