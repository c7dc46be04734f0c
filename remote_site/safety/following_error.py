"""Finds a following error of the telemanipulator: a dead servo, a drifting hand, or one that ignores its release.

A servo that does not overshoot is always at a mean of its recent set-points, for any lag and delay. So the measured
place lies within their range, or above it by the deflection of the servo under a finger's force. The check needs no
model of the servo, only the length of its memory.
"""

from collections.abc import Sequence

from common.faults.fault import AXES, TELEMANIPULATOR, Fault, FaultCode
from common.fingers import FINGERS
from remote_site.safety.servo import LONGEST_TICK_S, SERVO_N_M
from remote_site.safety.sliding_extrema import SlidingExtrema

PLANE_MARGIN_M = 0.004
"""Margin of the hand's place, m: rounding of the frames, and the swing of a hand that is stopped on its way."""
HEIGHT_MARGIN_M = 0.0020
"""Margin of a finger's height, m, likewise."""
PERSIST_S = 0.10
"""Duration for which every report must be outside, s, so that no single wrong, late or lost one counts."""
FRESH_S = 0.020
"""Maximum age of a report that counts, s."""
STOPPING_S = 0.25
"""Time after a release in which the hand comes to rest, s; then it must stay."""

_NAMES = (*AXES, *FINGERS)
_MARGIN_M = (PLANE_MARGIN_M, PLANE_MARGIN_M, *(HEIGHT_MARGIN_M,) * len(FINGERS))


class FollowingError:
    """Watches the hand's x and y and the fingers' heights: `step` for each report, then `commanded` for set-points.

    A place is seven numbers, m: x, y and the five heights.
    """

    def __init__(self) -> None:
        self._recent = [SlidingExtrema() for _ in _NAMES]
        self._commanded = False
        self._doubt_s = 0.0
        self._measured: tuple[Sequence[float], Sequence[float]] = ((), ())
        self._rest_m: list[float] = []
        self._released_s: float | None = None

    def step(
        self,
        dt_s: float,
        age_s: float,
        place_m: Sequence[float],
        force_n: Sequence[float],
        taking_part: Sequence[bool] = (True,) * len(FINGERS),
    ) -> Fault | None:
        """Return the fault, or None.

        Args:
            dt_s: time since the last call, s.
            age_s: age of the report, s.
            place_m: reported place, (7,), m, finite.
            force_n: contact force of each finger, (5,), N, finite.
            taking_part: fingers that are expected to move; the others may stand anywhere.
        """
        self._measured = (place_m, force_n)
        if not self._commanded or age_s > FRESH_S:
            return None
        for is_m, recent, margin_m in zip(place_m, self._recent, _MARGIN_M, strict=True):
            if not recent.lowest - margin_m <= is_m <= recent.highest + margin_m:
                break
        else:  # within the range without any deflection by forces
            self._doubt_s = 0.0
            return None
        wrong = self._outside(place_m, _bent_m(force_n), (True, True, *taking_part))
        self._doubt_s = self._doubt_s + min(LONGEST_TICK_S, dt_s) if wrong else 0.0
        return wrong if self._doubt_s >= PERSIST_S else None

    def commanded(self, t_s: float, place_m: Sequence[float], released: bool) -> None:
        """Take the set-points that are sent now, (7,), m, after the `step` of this tick.

        When released, the telemanipulator stops by itself, and fingers only rise. The place where it comes to rest
        then replaces the set-points.
        """
        if not released:
            self._released_s = None
        else:
            if self._released_s is None:
                self._released_s = t_s
            if not t_s - self._released_s >= STOPPING_S:  # a time that is not a number never judges
                measured_m, force_n = self._measured
                self._rest_m = [place - bent for place, bent in zip(measured_m, _bent_m(force_n), strict=True)]
            x_m, y_m, *z_m = self._rest_m
            place_m = [x_m, y_m, *map(max, z_m, place_m[2:])]
        for value, recent in zip(place_m, self._recent, strict=True):
            recent.add(t_s, value)
        self._commanded = True

    def _outside(self, place_m: Sequence[float], bent_m: Sequence[float], watched: Sequence[bool]) -> Fault | None:
        for name, margin_m, is_m, bent, looked_at, recent in zip(
            _NAMES, _MARGIN_M, place_m, bent_m, watched, self._recent, strict=True
        ):
            highest_m, lowest_m = recent.highest + bent, recent.lowest
            if looked_at and not lowest_m - margin_m <= is_m <= highest_m + margin_m:
                away_m = max(lowest_m - is_m, is_m - highest_m)
                return Fault(
                    FaultCode.SET_POINT_MISSED, name, TELEMANIPULATOR, value=away_m * 1e3, limit=margin_m * 1e3
                )
        return None


def _bent_m(force_n: Sequence[float]) -> list[float]:
    """Return the deflection of each part of a place by the forces, (7,), m; only fingers are deflected."""
    return [0.0, 0.0, *[max(0.0, newton) / SERVO_N_M for newton in force_n]]
