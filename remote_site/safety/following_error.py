"""Does the telemanipulator go where it is told? Finds a dead servo, a hand that drifts, one that ignores its release.

A servo that does not overshoot is at every moment at a mean of its recent set-points, whatever its lag and the delay
on the way there and back. So the measured place lies within their range, or above it by what a finger's force bends its
servo. No model of the servo is needed, only how long it remembers.
"""

from collections.abc import Sequence

from common.faults.fault import AXES, TELEMANIPULATOR, Fault, FaultCode
from common.fingers import FINGERS
from remote_site.safety.servo import LONGEST_TICK_S, SERVO_N_M
from remote_site.safety.sliding_extrema import SlidingExtrema

PLANE_MARGIN_M = 0.004
HEIGHT_MARGIN_M = 0.0020
"""Rounding of the frames, and how far a hand that is stopped on its way swings on."""
PERSIST_S = 0.10
"""So long every report must be outside: no single wrong, late or lost one counts."""
FRESH_S = 0.020
"""An older report does not add to the doubt."""
STOPPING_S = 0.25
"""Told to stay, it has come to rest after this; where it rests then it has to stay."""

_NAMES = (*AXES, *FINGERS)
_MARGIN_M = (PLANE_MARGIN_M, PLANE_MARGIN_M, *(HEIGHT_MARGIN_M,) * len(FINGERS))


class FollowingError:
    """Watches the hand's x and y and the fingers' heights: `step` for what it measured, then `commanded` what is sent.

    A place is seven numbers, m: x, y and the five heights.
    """

    def __init__(self) -> None:
        self._lately = [SlidingExtrema() for _ in _NAMES]
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
        """Return what is wrong, or None.

        Args:
            dt_s: time since the last call, s.
            age_s: age of the report, s.
            place_m: where the telemanipulator says it is, (7,), finite.
            force_n: contact force of each finger, (5,), N, finite.
            taking_part: fingers that are expected to move; the others may stand anywhere.
        """
        self._measured = (place_m, force_n)
        if not self._commanded or age_s > FRESH_S:
            return None
        for is_m, lately, margin_m in zip(place_m, self._lately, _MARGIN_M, strict=True):
            if not lately.lowest - margin_m <= is_m <= lately.highest + margin_m:
                break
        else:  # within the range without what forces bend
            self._doubt_s = 0.0
            return None
        wrong = self._outside(place_m, _bent_m(force_n), (True, True, *taking_part))
        self._doubt_s = self._doubt_s + min(LONGEST_TICK_S, dt_s) if wrong else 0.0
        return wrong if self._doubt_s >= PERSIST_S else None

    def commanded(self, t_s: float, place_m: Sequence[float], released: bool) -> None:
        """Take the set-points that are sent now, (7,), after the `step` of this tick.

        Released, the telemanipulator stops by itself and lets fingers only rise: what it holds then is seen from where
        it comes to rest.
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
        for value, lately in zip(place_m, self._lately, strict=True):
            lately.add(t_s, value)
        self._commanded = True

    def _outside(self, place_m: Sequence[float], bent_m: Sequence[float], watched: Sequence[bool]) -> Fault | None:
        for name, margin_m, is_m, bent, looked_at, lately in zip(
            _NAMES, _MARGIN_M, place_m, bent_m, watched, self._lately, strict=True
        ):
            highest_m, lowest_m = lately.highest + bent, lately.lowest
            if looked_at and not lowest_m - margin_m <= is_m <= highest_m + margin_m:
                away_m = max(lowest_m - is_m, is_m - highest_m)
                return Fault(
                    FaultCode.SET_POINT_MISSED, name, TELEMANIPULATOR, value=away_m * 1e3, limit=margin_m * 1e3
                )
        return None


def _bent_m(force_n: Sequence[float]) -> list[float]:
    """How far each part of a place is from where its servo holds it, (7,), m: a force bends a finger's servo."""
    return [0.0, 0.0, *[max(0.0, newton) / SERVO_N_M for newton in force_n]]
