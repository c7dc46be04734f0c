"""Numbers and dates the events of all fingers: taps, grooves and materials.

A groove belongs to the moment at which the operator's hand was over it. The telemanipulator arrives later, by the
delay and jitter of the network and by its own lag. The place alone gives that moment, whatever these delays are.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from common.exploration.sample_window import SampleWindow
from common.wire.messages import EVENT_MAX, MAX_EVENTS, Event, EventKind
from remote_site.devices.sensor_frame import HandPlace, SensorFrame

Floats = NDArray[np.float64]

KEPT_S = 0.6
"""Duration of the path that is kept, s; longer than the maximum delay of a link."""
MOST = 1024
"""Maximum number of places kept; the fastest loop takes fewer in KEPT_S. It holds for any times that a peer states."""
NEAR_M = 0.5e-3
"""Maximum distance at which the path counts as passing a place, m; the telemanipulator cuts corners."""
HISTORY_S = 0.25
"""Time for which every packet repeats an event, s; any later packet repairs a loss."""
FOUND_S = 0.1
"""Maximum delay between a groove and its detection, s; a stroke of 7 mm/s detects it 0.6 mm behind it."""


class TouchEvents:
    """Events of all fingers; step it before them in each tick.

    Attributes:
        new: events since the last step.
        recent: events of the last HISTORY_S, at most MAX_EVENTS, oldest first.
    """

    def __init__(self) -> None:
        self._count = 0
        self.forget()

    def forget(self) -> None:
        """Forget all places and events; numbers continue, so that no event repeats an earlier number."""
        self.new: list[Event] = []
        self.recent: deque[Event] = deque(maxlen=MAX_EVENTS)
        self._hand = HandPath()
        self._places = SampleWindow(FOUND_S)
        self._now = (0.0, 0.0, 0.0)

    def step(self, sensed: SensorFrame) -> None:
        """Take the places of the telemanipulator and of the operator's hand in this tick."""
        self.new = []
        self._now = sensed.time_s, sensed.x_m, sensed.y_m
        self._hand.step(sensed.hand)
        self._places.take(*self._now)
        while self.recent and sensed.time_s - self.recent[0].time_ns * 1e-9 > HISTORY_S:
            self.recent.popleft()

    def add(
        self, kind: EventKind, finger: int, value: float, name: str = "", time_s: float | None = None
    ) -> tuple[float, float]:
        """Add an event of a finger; return the place of the telemanipulator at the event, m.

        Args:
            kind: kind of the event.
            finger: number of the finger, 0..4.
            value: approach speed, m/s, amplitude, rad/s, or probability, as in `Event`; limited to 0..EVENT_MAX.
            name: name of a material.
            time_s: time of the event, s; None for this tick.
        """
        at_m = self._place_m(time_s)
        self._count += 1
        event = Event(
            self._count,
            kind,
            finger,
            round((self._now[0] if time_s is None else time_s) * 1e9),
            0 if kind is EventKind.MATERIAL else self._hand.when_ns(*at_m),
            min(max(float(value), 0.0), EVENT_MAX),
            name,
        )
        self.new.append(event)
        self.recent.append(event)
        return at_m

    def _place_m(self, time_s: float | None) -> tuple[float, float]:
        """Return the place of the telemanipulator at a time, s, or in this tick, m."""
        if time_s is None:
            return self._now[1:]
        times_s, xs_m, ys_m = self._places.tracks
        return float(np.interp(time_s, times_s, xs_m)), float(np.interp(time_s, times_s, ys_m))


class HandPath:
    """Path of the operator's hand in the last KEPT_S, with at most MOST places."""

    def __init__(self) -> None:
        self._rows: Floats = np.empty((2 * MOST, 3))
        """Time, ns, and place, m, oldest first; rows before `_first` are no longer used."""
        self._first = self._count = 0
        self._newest: HandPlace | None = None
        self._late_ns = 0.0

    def step(self, hand: HandPlace | None) -> None:
        """Take the place followed now, unchanged until a newer one arrives; None when nothing is followed."""
        newest = self._newest
        if hand is None or (newest is not None and hand.time_ns < newest.time_ns):
            self._first = self._count = 0
            self._newest, self._late_ns = None, 0.0
        if hand is None or (newest is not None and hand.time_ns == newest.time_ns):
            return
        rows = self._rows
        if self._count == len(rows):
            rows[:MOST] = rows[MOST:]
            self._first, self._count = max(0, self._first - MOST), MOST
        rows[self._count] = self._newest = hand
        self._count += 1
        self._first = max(self._first, self._count - MOST)
        while hand.time_ns - rows[self._first, 0] > KEPT_S * 1e9:
            self._first += 1

    def when_ns(self, x_m: float, y_m: float) -> int:
        """Return when the hand was at this place, ns on the operator's clock; 0 when nothing is followed.

        After several passes, the pass counts whose delay is nearest to the delay of the previous answer. If the path
        never passed the place, the newest time counts.
        """
        if self._newest is None:
            return 0
        way = self._rows[self._first : self._count]
        times_ns, away_m = _nearest(way, x_m, y_m)
        before, after = np.concatenate(([np.inf], away_m[:-1])), np.concatenate((away_m[1:], [np.inf]))
        passes_ns = times_ns[(away_m <= NEAR_M) & (away_m <= before) & (away_m < after)]
        newest_ns = self._newest.time_ns
        if not passes_ns.size:
            return newest_ns
        late_ns = newest_ns - way[0, 0] - passes_ns
        found = int(np.argmin(np.abs(late_ns - self._late_ns)))
        self._late_ns = float(late_ns[found])
        return newest_ns - round(self._late_ns)


def _nearest(way: Floats, x_m: float, y_m: float) -> tuple[Floats, Floats]:
    """Return the time, ns from the path's start, and the distance, m, at which each segment is nearest to the place."""
    times_ns = way[:, 0] - way[0, 0]
    if len(way) == 1:
        return times_ns, np.hypot(way[:, 1] - x_m, way[:, 2] - y_m)
    step, passed_ns = way[1:, 1:] - way[:-1, 1:], times_ns[1:] - times_ns[:-1]
    to_place = (x_m, y_m) - way[:-1, 1:]
    square = (step * step).sum(axis=1)
    part = np.minimum(np.maximum((to_place * step).sum(axis=1) / np.maximum(square, 1e-18), 0.0), 1.0)
    missed = to_place - part[:, None] * step
    return times_ns[:-1] + part * passed_ns, np.hypot(missed[:, 0], missed[:, 1])
