"""Perceptual deadband with dead reckoning (Hinterseer et al. 2008): omits packets whose change nobody would perceive.

A packet is sent when a number is off by more than its threshold, and at least at the refresh interval. Each number is
compared by itself: a norm over several would hide one that is old. Both ends extrapolate the hand alike, so that the
sender knows the receiver's estimate.

Without changes a packet follows every 12 ms. The far side sees a gap of more than 0.1 s only after eight lost
refreshes in a row. With a fifth of all packets lost at random this occurs 0.6 times an hour. A change is repeated in
the next tick, so that one lost packet leaves no error.
"""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.timing.timeouts import REFRESH_S
from common.wire.messages import TOUCH_BLOCK, TOUCH_FIELDS, MotionRow, Touch
from common.wire.packets import Floats

PLANE_M = 0.25e-3
"""Threshold of a place along the bench, m; a quarter of the 1 mm that a hand can distinguish."""
HEIGHT_M = 0.10e-3
"""Threshold of a finger's height, m; pressed into the telemanipulator's 1000 N/m it is 0.1 N, 7 % of 1.4 N."""
FORCE_WEBER = 0.07
"""Relative threshold of a force, and of a stiffness, which is perceived by its force (Jones 1989: 7 to 10 %)."""
_DAMPING_WEBER = 0.15
"""Relative threshold of damping; half of the difference that people distinguish (Jones & Hunter 1993: 34 %)."""
_SLOPE = 0.02
"""Threshold of a slope; over 5 mm, 50 ms of a stroke of 100 mm/s, it is the threshold of a finger's height."""
_RATE_WEBER = 0.10
"""Relative threshold of vibrations and their decay; a third of what people distinguish (Israr & Tan 2006)."""
_HEAT_WEBER = 0.05
"""Relative threshold of a thermal constant; together at most 7 % of the effusivity. People distinguish 43 %."""


class Threshold(NamedTuple):
    """The largest difference that is not sent: a share of the number sent last, or `least`, whichever is more."""

    share: float
    least: float


_ANY_CHANGE = Threshold(0.0, 0.0)
_NO_CHANGE = Threshold(0.0, math.inf)
"""Threshold of a number that is sent only along with others."""
TOUCH_STEPS: Mapping[str, Threshold] = {
    "mode": _ANY_CHANGE,
    "contact": _ANY_CHANGE,
    "contact_force_n": Threshold(FORCE_WEBER, 0.05),
    "x_m": _NO_CHANGE,
    "y_m": _NO_CHANGE,
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
    "thermal_status": _ANY_CHANGE,
    "thermal_reason": _ANY_CHANGE,
}
"""Threshold of each column of the touch block; 0.1 C is the best threshold of a hand."""
_SHARE = np.array([TOUCH_STEPS[name].share for name in TOUCH_FIELDS])
_LEAST = np.array([TOUCH_STEPS[name].least for name in TOUCH_FIELDS])
REPEATS = 1
"""Number of repetitions of a change in the following ticks."""
_EARLY = 0.75
"""Share of a period: a tick less than this before the refresh sends at once."""
_APART_S = 0.008
"""Minimum time between two packets for a speed estimate, s: positions are rounded to 0.02 mm."""
TOGETHER_S = 0.05
"""Maximum time between two packets of one movement, s."""
ONWARDS_S = 2.0 * REFRESH_S
"""Maximum extrapolation, s. It bridges one lost or late refresh; after more, the position stays constant."""
_ROUNDING_S = 1e-6

Places = Sequence[MotionRow]
"""Place of each fingertip, m."""


class Deadband:
    """Decides for each tick whether to send. The caller decides whether a change is perceptible.

    Attributes:
        spared: number of ticks without a packet.
    """

    def __init__(self, period_s: float, repeats: int = REPEATS) -> None:
        """Decide for a loop with this period, s, and repeat each change `repeats` times."""
        self._early_s = _EARLY * period_s
        self._repeats = repeats
        self._sent_s = -math.inf
        self._again = 0
        self.spared = 0

    def step(self, t_s: float, changed: bool, refresh_s: float = REFRESH_S) -> bool:
        """Return whether to send at `t_s`, s: on a change that the far side would perceive, or after `refresh_s`, s."""
        if changed:
            self._again = 1 + self._repeats
        quiet_s = refresh_s - self._early_s
        if not self._again and 0.0 <= t_s - self._sent_s <= quiet_s:  # a clock that was set back sends
            self.spared += 1
            return False
        self._again = max(0, self._again - 1)
        self._sent_s = t_s
        return True


class DeadReckoning:
    """Extrapolates from the last places at the speed between them."""

    def __init__(self) -> None:
        self._taken: deque[tuple[float, Places]] = deque()
        self._last_s = 0.0
        self._last: Places | None = None
        self._speeds: list[tuple[float, float, float]] | None = None
        """Speed of each fingertip in x, y and z, m/s; None while it is not known."""

    def take(self, t_s: float, places: Places) -> None:
        """Take the places of a packet and its source time, s. A clock that was set back starts over."""
        taken = self._taken
        if taken and t_s <= self._last_s:
            taken.clear()
        taken.append((t_s, places))
        while len(taken) > 2 and t_s - taken[1][0] >= _APART_S - _ROUNDING_S:
            taken.popleft()
        before_s, before = taken[0]
        apart_s = t_s - before_s
        self._speeds = None
        if _APART_S - _ROUNDING_S <= apart_s <= TOGETHER_S:
            pairs = zip(places, before, strict=True)
            self._speeds = [
                ((x - x_before) / apart_s, (y - y_before) / apart_s, (z - z_before) / apart_s)
                for (x, y, z), (x_before, y_before, z_before) in pairs
            ]
        self._last_s, self._last = t_s, places

    def at(self, t_s: float) -> Places | None:
        """Return the places at a time on the sender's clock, s; None before the first packet."""
        onwards_s = min(t_s - self._last_s, ONWARDS_S)
        if self._last is None or self._speeds is None or onwards_s <= 0.0:
            return self._last
        moving = zip(self._last, self._speeds, strict=True)
        return [
            MotionRow(x + onwards_s * x_m_s, y + onwards_s * y_m_s, z + onwards_s * z_m_s)
            for (x, y, z), (x_m_s, y_m_s, z_m_s) in moving
        ]


def motion_perceptible(expected: Places, true: Places) -> bool:
    """Return whether a fingertip's places, m, differ by more than a threshold in any direction."""
    for (x, y, z), (x_true, y_true, z_true) in zip(expected, true, strict=True):
        if abs(x_true - x) > PLANE_M or abs(y_true - y) > PLANE_M or abs(z_true - z) > HEIGHT_M:
            return True
    return False


def touch_perceptible(sent: Touch, true: Touch) -> bool:
    """Return whether a touch has a new state, material or event, or a number that differs by its threshold."""
    if true.state is not sent.state or true.materials != sent.materials:
        return True
    if true.events and (not sent.events or true.events[-1].ident > sent.events[-1].ident):
        return True
    if true.floats == sent.floats:
        return False
    was, steps = _steps(sent.floats)
    return bool(np.count_nonzero(np.abs(true.block - was) > steps))


@lru_cache(maxsize=2)
def _steps(floats: bytes) -> tuple[Floats, NDArray[np.float64]]:
    """Return the touch block sent last, and the largest difference of each number that need not be sent."""
    was = TOUCH_BLOCK.array(floats)
    return was, np.maximum(_LEAST, _SHARE * np.abs(was))
