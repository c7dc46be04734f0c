"""What a far side would feel of a difference between what it was told and what is true.

Each number is compared by itself: a norm over several would hide one that is old (Hinterseer et al. 2008).
"""

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.wire.messages import TOUCH_BLOCK, TOUCH_FIELDS, Touch
from common.wire.packets import Floats

PLANE_M = 0.25e-3
"""Along the bench: a quarter of the 1 mm that a hand can tell."""
HEIGHT_M = 0.10e-3
"""Of a finger: pressed into the telemanipulator's 1000 N/m that is 0.1 N, 7 % of 1.4 N."""
_MOTION_M = np.array([PLANE_M, PLANE_M, HEIGHT_M])

FORCE_WEBER = 0.07
"""Of a force, and of a stiffness, which is felt by its force (Jones 1989: 7 to 10 %)."""
_DAMPING_WEBER = 0.15
"""Half of what is told apart (Jones & Hunter 1993: 34 %)."""
_SLOPE = 0.02
"""Over 5 mm, 50 ms of a stroke of 100 mm/s, that is the height of a finger that is told."""
_RATE_WEBER = 0.10
"""Of vibrations and of their decay: a third of what is told apart (Israr & Tan 2006)."""
_HEAT_WEBER = 0.05
"""Of each thermal constant; together 7 % of the effusivity at most, of which people tell 43 % apart."""


class Threshold(NamedTuple):
    """The largest difference that is not told: a share of what was told last, or, where that is more, so much."""

    share: float
    least: float


_AT_ONCE = Threshold(0.0, 0.0)
_BY_ITSELF_NEVER = Threshold(0.0, math.inf)
"""Only says where the others were true."""
TOUCH_STEPS: Mapping[str, Threshold] = {
    "mode": _AT_ONCE,
    "contact": _AT_ONCE,
    "contact_force_n": Threshold(FORCE_WEBER, 0.05),
    "x_m": _BY_ITSELF_NEVER,
    "y_m": _BY_ITSELF_NEVER,
    "surface_z_m": Threshold(0.0, HEIGHT_M),
    "stiffness_n_m": Threshold(FORCE_WEBER, 0.0),
    "stiffness_ln_sd": Threshold(0.10, 0.02),
    "damping_n_s_m": Threshold(_DAMPING_WEBER, 0.1),
    "slope_x": Threshold(0.0, _SLOPE),
    "slope_y": Threshold(0.0, _SLOPE),
    "k_tap": Threshold(_RATE_WEBER, 0.0),
    "b_tap_per_s": Threshold(_RATE_WEBER, 0.0),
    "k_stroke_v": Threshold(_RATE_WEBER, 0.0),
    "k_stroke_f": Threshold(_RATE_WEBER, 0.0),
    "groove_rad_s": Threshold(_RATE_WEBER, 0.0),
    "b_groove_per_s": Threshold(_RATE_WEBER, 0.0),
    "conductivity_w_mk": Threshold(_HEAT_WEBER, 0.0),
    "density_kg_m3": Threshold(_HEAT_WEBER, 0.0),
    "specific_heat_j_kgk": Threshold(_HEAT_WEBER, 0.0),
    "effusivity_ln_sd": Threshold(0.10, 0.02),
    "object_c": Threshold(0.0, 0.1),
    "object_c_sd": Threshold(0.10, 0.05),
    "probability": Threshold(0.0, 0.05),
    "thermal_status": _AT_ONCE,
    "thermal_reason": _AT_ONCE,
}
"""For each column of the touch block. 0.1 C is the best threshold of the hand; the last columns are read, not felt."""
_SHARE = np.array([TOUCH_STEPS[name].share for name in TOUCH_FIELDS])
_LEAST = np.array([TOUCH_STEPS[name].least for name in TOUCH_FIELDS])


def motion_perceptible(told_m: NDArray[np.float64], true_m: NDArray[np.float32]) -> bool:
    """Whether places (5, 3), m, differ by more than a hand would notice, in any direction of any finger."""
    return bool(np.count_nonzero(np.abs(true_m - told_m) > _MOTION_M))


def touch_perceptible(told: Touch, true: Touch) -> bool:
    """Whether there is news in a touch: a state, a material's name, an event, or a number that differs by a step."""
    if true.state is not told.state or true.materials != told.materials:
        return True
    if true.events and (not told.events or true.events[-1].ident > told.events[-1].ident):
        return True
    if true.floats == told.floats:
        return False
    was, steps = _steps(told.floats)
    return bool(np.count_nonzero(np.abs(true.block - was) > steps))


@lru_cache(maxsize=2)
def _steps(floats: bytes) -> tuple[Floats, NDArray[np.float64]]:
    """The touch block sent last, and the largest difference of each number that need not be sent."""
    was = TOUCH_BLOCK.array(floats)
    return was, np.maximum(_LEAST, _SHARE * np.abs(was))
