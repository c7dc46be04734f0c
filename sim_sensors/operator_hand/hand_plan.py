"""Plan the movements of the scripted hand from a scene's script.

A plan is one pass through the script. Lowering and lifting are minimum-jerk movements. Travel and strokes start
and stop with minimum jerk and have constant speed in between. Depth, speed and timing vary a little from step to
step, as a person's do; the variation is seeded.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.scenes.scene import Scene
from common.scenes.script import Hold, Lift, Move, Presses, Step, Stroke, Strokes, Tap, Touch, Wait

HOVER_M = 0.006
DEPTH_M = 0.004
DEPTH_SPREAD_M = 0.0003
TAP_DEPTH_M = 0.003
TOUCH_S = 0.37
LIFT_S = 0.25
TAP_DOWN_S = 0.26
TAP_UP_S = 0.20
TAP_PAUSE_S = 0.15
TRAVEL_M_S = 0.25
RAMP_S = 0.12
"""Time to reach a constant speed or to stop, s."""
VARIATION = 0.04
"""Relative standard deviation of speed and duration when a person repeats a movement."""

FREE, TAPPING, QUIESCENT, STROKING = range(4)
TAPPING_S = 0.15
STROKE_FROM_M = 0.002
STROKE_FROM_M_S = 0.010


def minimum_jerk(u: float) -> float:
    """Return the fraction of the path after the fraction `u` of the time (Flash & Hogan 1985)."""
    u = min(max(u, 0.0), 1.0)
    return u * u * u * (10.0 + u * (6.0 * u - 15.0))


def _ramp_area(u: float) -> float:
    """Return the integral of `minimum_jerk` from 0 to `u`."""
    return u**4 * (2.5 + u * (u - 3.0))


@dataclass(frozen=True, slots=True)
class Segment:
    """One movement of the plan; times count from the plan's start.

    Attributes:
        act: name of the movement in the script.
        object: object at which the hand is or to which it goes.
        start_s, duration_s: start and duration.
        from_x_m, to_x_m, from_y_m, to_y_m: start and end of the hand's path.
        speed_m_s: constant speed along the path.
        from_z_m, to_z_m: wanted heights of the fingers at start and end, (5,).
        contact_s: time at which the fingers cross the surface downwards, None while they are up.
        release_s: time at which they cross it upwards, None if they do not.
        tap_x_m: x at which the fingers came down.
    """

    act: str
    object: str
    start_s: float
    duration_s: float
    from_x_m: float
    to_x_m: float
    from_y_m: float
    to_y_m: float
    speed_m_s: float
    from_z_m: NDArray[np.float64]
    to_z_m: NDArray[np.float64]
    contact_s: float | None
    release_s: float | None
    tap_x_m: float

    def way(self, t_s: float) -> tuple[float, float]:
        """Return the fraction of the path along x and y, and the speed in m/s, at the plan's time `t_s`."""
        distance = _path_m(self.to_x_m - self.from_x_m, self.to_y_m - self.from_y_m)
        if distance == 0.0:
            return minimum_jerk((t_s - self.start_s) / self.duration_s), 0.0
        since, left = t_s - self.start_s, self.start_s + self.duration_s - t_s
        ends = self.speed_m_s * RAMP_S
        if since < RAMP_S:
            u = max(since / RAMP_S, 0.0)
            return ends * _ramp_area(u) / distance, self.speed_m_s * minimum_jerk(u)
        if left < RAMP_S:
            u = max(left / RAMP_S, 0.0)
            return 1.0 - ends * _ramp_area(u) / distance, self.speed_m_s * minimum_jerk(u)
        return (0.5 * ends + self.speed_m_s * (since - RAMP_S)) / distance, self.speed_m_s


class Wanted(NamedTuple):
    """Wanted state of the hand at one time: position, heights (5,), and intended exploration mode."""

    x_m: float
    y_m: float
    z_m: NDArray[np.float64]
    mode: int
    segment: Segment


class HandPlan:
    """One pass through a script.

    Attributes:
        segments: its movements, in order, without gaps.
        seconds: its duration.
    """

    def __init__(
        self,
        scene: Scene,
        used: NDArray[np.bool_],
        rng: np.random.Generator,
        start: tuple[float, float] | None = None,
    ) -> None:
        """Lay the scene's script out.

        Args:
            scene: the objects and the script.
            used: which fingers touch, (5,); the others stay up.
            rng: source of the person's variation.
            start: position of the hand, (x, y) in m; by default over the first object that the script goes to.
        """
        self._scene = scene
        self._used = used
        self._rng = rng
        self.segments: list[Segment] = []
        self.seconds = 0.0
        self._z = np.full(len(used), HOVER_M)
        self._contact_s: float | None = None
        self._tap_x = 0.0
        self._at = scene.objects[0].name
        self._x, self._y = self._beginning() if start is None else start
        for step in scene.script:
            self._lay(step)
        if self._contact_s is not None:
            self._lift(LIFT_S)
        self._add("end", 0.01)  # a script without any movement still takes time
        self._starts = [segment.start_s for segment in self.segments]

    @property
    def end(self) -> tuple[float, float]:
        """Position of the hand at the plan's end, (x, y) in m."""
        return self._x, self._y

    def at(self, t_s: float) -> Wanted:
        """Return the wanted state `t_s` after the plan's start (before 0: the start; after the end: the end)."""
        segment = self.segments[max(0, bisect_right(self._starts, t_s) - 1)]
        t_s = min(max(t_s, segment.start_s), segment.start_s + segment.duration_s)
        way, speed = segment.way(t_s)
        x = segment.from_x_m + (segment.to_x_m - segment.from_x_m) * way
        y = segment.from_y_m + (segment.to_y_m - segment.from_y_m) * way
        z = segment.from_z_m
        if segment.to_z_m is not z:
            z = z + (segment.to_z_m - z) * minimum_jerk((t_s - segment.start_s) / segment.duration_s)
        return Wanted(x, y, z, _mode(segment, t_s, x, speed), segment)

    def _beginning(self) -> tuple[float, float]:
        """Return the first position of the script; the middle of the first object for a script without movement."""
        for step in self._scene.script:
            match step:
                case Move(object=name, u=u):
                    return self._place(name, u)
                case Presses(x_m=x_m, y_m=y_m) | Strokes(x_m=x_m, y_m=y_m):
                    return self._bench_place(x_m[0], y_m[0])
        return self._place(self._at, 0.5)

    def _bench_place(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Return a position on the bench, and make the object there the present one."""
        below = (item.name for item in self._scene.objects if item.covers(x_m, y_m))
        self._at = next(below, self._at)
        return x_m, y_m

    def _place(self, name: str, u: float) -> tuple[float, float]:
        """Return the hand's position at fraction `u` of an object, with the middle finger over its middle in y."""
        item = self._scene.object_named(name)
        self._at = name
        return item.x_at(u), sum(item.y_range_m) / 2.0

    def _lay(self, step: Step) -> None:
        match step:
            case Move(object=name, u=u):
                if self._contact_s is not None:
                    self._lift(LIFT_S)
                x, y = self._place(name, u)
                self._travel("move", x, y, TRAVEL_M_S)
            case Stroke(to_object=name, u=u, speed_mm_s=speed_mm_s):
                x, _ = self._place(name, u)
                self._travel("stroke", x, self._y, 1e-3 * speed_mm_s * self._vary())
            case Touch():
                self._lower("touch", DEPTH_M, TOUCH_S)
            case Hold(act=act, seconds=seconds) | Wait(act=act, seconds=seconds):
                self._add(act, seconds)
            case Lift():
                self._lift(LIFT_S)
            case Presses():
                self._press(step)
            case Strokes():
                self._stroke(step)
            case Tap(times=times):
                for _ in range(times):
                    self._lower("tap", TAP_DEPTH_M, TAP_DOWN_S)
                    self._lift(TAP_UP_S, "tap")
                    self._add("tap", TAP_PAUSE_S)

    def _press(self, step: Presses) -> None:
        for y_m in step.y_m:
            for x_m in step.x_m:
                self._travel("move", *self._bench_place(x_m, y_m), TRAVEL_M_S)
                if step.wait_s:
                    self._add("wait", step.wait_s)
                as_fast_s = TOUCH_S * ((HOVER_M + step.depth_m) / (HOVER_M + DEPTH_M))
                self._lower("touch", step.depth_m, as_fast_s, step.fingers)
                self._add("hold", step.hold_s)
                self._lift(LIFT_S)

    def _stroke(self, step: Strokes) -> None:
        for y_m in step.y_m:
            self._travel("move", *self._bench_place(step.x_m[0], y_m), TRAVEL_M_S)
            self._lower("touch", DEPTH_M, TOUCH_S)
            for x_m in reversed(step.x_m):
                self._travel("stroke", *self._bench_place(x_m, y_m), 1e-3 * step.speed_mm_s * self._vary())
            self._lift(LIFT_S)

    def _vary(self) -> float:
        return float(np.clip(1.0 + VARIATION * self._rng.standard_normal(), 0.9, 1.1))

    def _travel(self, act: str, x_m: float, y_m: float, speed_m_s: float) -> None:
        distance = _path_m(x_m - self._x, y_m - self._y)
        if abs(x_m - self._x) < 1e-4 and abs(y_m - self._y) < 1e-4:
            return
        speed_m_s = min(speed_m_s, distance / RAMP_S) if distance else speed_m_s
        seconds = distance / speed_m_s + RAMP_S if distance else 2.0 * RAMP_S + abs(y_m - self._y) / speed_m_s
        self._add(act, seconds, x_m=x_m, y_m=y_m, speed_m_s=speed_m_s)

    def _lower(self, act: str, depth_m: float, seconds: float, fingers: Sequence[str] = FINGERS) -> None:
        deep = depth_m + DEPTH_SPREAD_M * np.clip(self._rng.standard_normal(len(self._used)), -2.0, 2.0)
        touching = self._used & [finger in fingers for finger in FINGERS]
        to_z = np.where(touching, -deep, HOVER_M)
        seconds *= self._vary()
        if self._contact_s is None:
            self._contact_s = self.seconds + seconds * _time_at(HOVER_M / (HOVER_M + depth_m))
            self._tap_x = self._x
        self._add(act, seconds, to_z=to_z)

    def _lift(self, seconds: float, act: str = "lift") -> None:
        seconds *= self._vary()
        depth = float(-self._z.min())
        release = self.seconds + seconds * _time_at(depth / (HOVER_M + depth)) if depth > 0.0 else None
        self._add(act, seconds, to_z=np.full(len(self._used), HOVER_M), release_s=release)
        self._contact_s = None

    def _add(
        self,
        act: str,
        seconds: float,
        *,
        x_m: float | None = None,
        y_m: float | None = None,
        speed_m_s: float = 0.0,
        to_z: NDArray[np.float64] | None = None,
        release_s: float | None = None,
    ) -> None:
        x_m = self._x if x_m is None else x_m
        y_m = self._y if y_m is None else y_m
        to_z = self._z if to_z is None else to_z
        self.segments.append(
            Segment(
                act,
                self._at,
                self.seconds,
                seconds,
                self._x,
                x_m,
                self._y,
                y_m,
                speed_m_s,
                self._z,
                to_z,
                self._contact_s,
                release_s,
                self._tap_x,
            )
        )
        self._x, self._y, self._z = x_m, y_m, to_z
        self.seconds += seconds


def _path_m(x_m: float, y_m: float) -> float:
    """Return the length of a path that has a constant speed in between; a path along y alone has none, and gives 0."""
    return math.hypot(x_m, y_m) if x_m else 0.0


def _mode(segment: Segment, t_s: float, x_m: float, speed_m_s: float) -> int:
    """Return the intended exploration mode: the paper's rule, applied to the wanted path."""
    if segment.contact_s is None or t_s < segment.contact_s:
        return FREE
    if segment.release_s is not None and t_s >= segment.release_s:
        return FREE
    if t_s < segment.contact_s + TAPPING_S:
        return TAPPING
    moved = abs(x_m - segment.tap_x_m) > STROKE_FROM_M
    return STROKING if moved and speed_m_s > STROKE_FROM_M_S else QUIESCENT


def _time_at(way: float) -> float:
    """Return the fraction of the time after which a minimum-jerk movement has covered the fraction `way`."""
    low, high = 0.0, 1.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if minimum_jerk(middle) < way else (low, middle)
    return low
