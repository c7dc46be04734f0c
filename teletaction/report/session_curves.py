"""Extracts from a session what figures draw: curves of one finger, spans of one mode, touches of one object."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from common.fingers import FINGERS
from teletaction.recordings.columns import Floats
from teletaction.recordings.session_data import Series, SessionData
from teletaction.recordings.true_touches import Touch, true_touches

_TOGETHER_S = 0.3
"""Largest time after a shared touch at which a further touch of its object still joins it, s."""


@dataclass(frozen=True, slots=True)
class Curve:
    """One value over time: `time_s` since the session's start and `value`, both (n,); NaN where unknown."""

    time_s: Floats
    value: Floats

    def thinned(self, bins: int) -> "Curve":
        """Reduce to two points per bin, its minimum and maximum, so that no peak is lost."""
        count = len(self.time_s)
        if count <= 2 * bins:
            return self
        first = np.linspace(0, count, bins, endpoint=False).astype(int)
        low, high = np.fmin.reduceat(self.value, first), np.fmax.reduceat(self.value, first)
        return Curve(np.repeat(self.time_s[first], 2), np.column_stack((low, high)).ravel())


@dataclass(slots=True)
class SharedTouch:
    """Touches of one object by several fingers at once."""

    thing: str
    touches: list[Touch] = field(default_factory=list)

    @property
    def start_s(self) -> float:
        """Time of the first contact, s."""
        return min(touch.start_s for touch in self.touches)

    @property
    def end_s(self) -> float:
        """Time of the last release, s."""
        return max(touch.end_s for touch in self.touches)


@dataclass(frozen=True, slots=True)
class SessionCurves:
    """A session's curves on a clock that starts when the operator site engages.

    Attributes:
        data: the recording.
        fingers: numbers of the fingers in use.
        zero_s: the recording's time at the session's start, s.
        shown_s: first and last time to show, s since the session's start.
        touches: true contacts of all fingers, in order of time.
    """

    data: SessionData
    fingers: tuple[int, ...]
    zero_s: float
    shown_s: tuple[float, float]
    touches: tuple[Touch, ...]

    @classmethod
    def of(cls, data: SessionData, fingers: Sequence[str] = FINGERS) -> "SessionCurves":
        """Find the session's start and touches; `fingers` are those in use."""
        series = [s for s in (data.touch, data.rendered, data.gate, data.fingertips, data.contact) if len(s)]
        first_s = min((float(s.time_s[0]) for s in series), default=0.0)
        last_s = max((float(s.time_s[-1]) for s in series), default=first_s)
        engaged = np.flatnonzero(data.rendered.values.get("engaged", np.empty(0)) > 0)
        zero_s = float(data.rendered.time_s[engaged[0]]) if len(engaged) else first_s
        shown_s = (max(first_s - zero_s, -1.0), max(last_s - zero_s, 1e-3))
        used = tuple(map(FINGERS.index, fingers))
        return cls(data, used, zero_s, shown_s, tuple(true_touches(data.truth_events, shown_s[1], zero_s)))

    def curve(self, series: Series, name: str, finger: int) -> Curve | None:
        """Return one finger's values of one field; None if nothing was recorded."""
        values = series.values.get(name)
        if values is None or not len(values) or values.ndim != 2:
            return None
        time_s = series.time_s - self.zero_s
        shown = time_s >= self.shown_s[0]
        value = np.where(np.isfinite(values[shown, finger]), values[shown, finger], np.nan)
        return None if np.isnan(value).all() else Curve(time_s[shown], value)

    def thermal(self, finger: int, name: str) -> Curve | None:
        """Return one value of a finger's thermal identification over time; None if it was never known."""
        rows = self.data.thermal.get(finger, [])
        value = np.array([row.get(name) for row in rows], dtype=np.float64)  # None becomes NaN
        if not np.isfinite(value).any():
            return None
        return Curve(np.array([row["time_s"] for row in rows]) - self.zero_s, value)

    def answers(self, touch: Touch) -> list[dict[str, Any]]:
        """Return the results of the thermal identification during a touch, with `time_s` since contact."""
        begin_s = touch.start_s + self.zero_s
        found = self.data.answers(touch.finger, begin_s, touch.end_s + self.zero_s)
        return [{**row, "time_s": row["time_s"] - begin_s} for row in found]

    def shared_touches(self, fingers: Iterable[int], least_s: float = 0.0) -> list[SharedTouch]:
        """Group touches of these fingers of at least `least_s` (s) by object and time."""
        wanted = set(fingers)
        found: list[SharedTouch] = []
        newest: dict[str, SharedTouch] = {}
        for touch in self.touches:
            if touch.finger not in wanted or touch.end_s - touch.start_s < least_s:
                continue
            shared = newest.get(touch.thing)
            if shared is None or touch.start_s > shared.end_s + _TOGETHER_S:
                shared = newest[touch.thing] = SharedTouch(touch.thing)
                found.append(shared)
            shared.touches.append(touch)
        return found


def spans(curve: Curve) -> list[tuple[float, float, int]]:
    """Return the spans of a constant integer: (start s, end s, number). Unknown spans are left out."""
    if not len(curve.time_s):
        return []
    number = np.where(np.isnan(curve.value), -1, curve.value).astype(int)
    first = np.concatenate(([0], np.flatnonzero(np.diff(number)) + 1))
    last = np.concatenate((first[1:], [len(number) - 1]))
    rows = zip(curve.time_s[first].tolist(), curve.time_s[last].tolist(), number[first].tolist(), strict=True)
    return [(start, end, value) for start, end, value in rows if value >= 0]


def held_s(time_s: Floats) -> Floats:
    """Return the time from each sample to the next, s, limited to five times the median.

    The limit bounds the effect of pauses in a recording. The last sample gets 0.
    """
    if len(time_s) < 2:
        return np.zeros(len(time_s))
    gaps = np.diff(time_s)
    return np.append(np.minimum(gaps, 5 * np.median(gaps)), 0.0)
