"""When a groove is felt: as far behind the hand as the one before it, however unevenly the link delivers them.

A groove is told with the time at which the operator's hand was there, on the operator's own clock. Played at once,
those that a lost packet held up would come in a heap, and a regular grating would not be felt as one. So each waits
until it is as late as the latest of a while ago: its way behind the hand stays, and so does that of its neighbours.
"""

import math
from collections import deque
from collections.abc import Iterable

from common.wire.messages import Event, EventKind

LONGEST_WAIT_S = 0.040
"""Later than that a texture feels like another one (Okamoto et al. 2009): what comes later still is not waited for."""
OLDEST_S = 1.0
"""What says that it is older than that, or from the future, says nothing of when it belongs: it is played at once."""
MEMORY_S = 3.0
"""How long a late one is remembered."""


class GrooveTiming:
    """Holds grooves back until their time; every other event passes.

    Attributes:
        behind_s: how far behind the hand grooves are felt now, s.
    """

    def __init__(self) -> None:
        self.behind_s = 0.0
        self._ages: deque[tuple[float, float]] = deque()
        self._waiting: deque[Event] = deque()

    @property
    def waits(self) -> bool:
        """Whether any groove is held back."""
        return bool(self._waiting)

    def step(self, t_s: float, fresh: Iterable[Event]) -> list[Event]:
        """Events whose time has come, in the order in which they happened.

        Args:
            t_s: time now on the operator's clock, s.
            fresh: events that were not given before, in their order.
        """
        due = []
        for event in fresh:
            age_s = t_s - event.hand_ns * 1e-9
            if event.kind is EventKind.GROOVE and 0.0 <= age_s <= OLDEST_S:
                self._ages.append((t_s, age_s))
                self._waiting.append(event)
                continue
            if event.kind is EventKind.TAP:  # a tap waits for nothing; what happened before it is not felt after it
                due += [earlier for earlier in self._waiting if earlier.finger == event.finger]
                self._waiting = deque(later for later in self._waiting if later.finger != event.finger)
            due.append(event)
        if self._waiting:
            self._look_back(t_s)
            while self._waiting and t_s - self._waiting[0].hand_ns * 1e-9 >= self.behind_s - 1e-6:
                due.append(self._waiting.popleft())
        return due

    def clear(self) -> None:
        """Nothing is to be felt: what waits is dropped."""
        self._waiting.clear()

    def _look_back(self, t_s: float) -> None:
        """The latest of the last MEMORY_S sets the pace, unless the soonest would wait for too long."""
        ages = self._ages
        while ages and not t_s - MEMORY_S <= ages[0][0] <= t_s:
            ages.popleft()
        known = [age_s for _, age_s in ages]
        soonest_s = min(known, default=math.inf)
        self.behind_s = min(max(known, default=0.0), soonest_s + LONGEST_WAIT_S)
