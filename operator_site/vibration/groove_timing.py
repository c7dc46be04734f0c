"""Schedules grooves with a constant delay behind the hand, however unevenly the link delivers them.

Each groove carries the time at which the operator's hand was there, on the operator's clock. Played on arrival, the
grooves that a lost packet held up would come in a burst, and a regular grating would feel irregular. So each groove
waits until its age reaches the largest recent age, which keeps its spacing to its neighbours.
"""

import math
from collections import deque
from collections.abc import Iterable

from common.wire.messages import Event, EventKind

LONGEST_WAIT_S = 0.040
"""Longest added delay of a groove, s; a larger delay changes the perceived texture (Okamoto et al. 2009)."""
OLDEST_S = 1.0
"""Largest plausible age of a groove, s; an older one, or one from the future, is played at once."""
MEMORY_S = 3.0
"""Time for which the age of a groove is remembered, s."""


class GrooveTiming:
    """Delays grooves until they are due; all other events pass at once.

    Attributes:
        behind_s: present delay of grooves behind the hand, s.
    """

    def __init__(self) -> None:
        self.behind_s = 0.0
        self._ages: deque[tuple[float, float]] = deque()
        self._waiting: deque[Event] = deque()

    @property
    def waits(self) -> bool:
        """Whether any groove is delayed."""
        return bool(self._waiting)

    def step(self, t_s: float, fresh: Iterable[Event]) -> list[Event]:
        """Return the due events in the order in which they happened.

        Args:
            t_s: present time on the operator's clock, s.
            fresh: new events in their order.
        """
        due = []
        for event in fresh:
            age_s = t_s - event.hand_ns * 1e-9
            if event.kind is EventKind.GROOVE and 0.0 <= age_s <= OLDEST_S:
                self._ages.append((t_s, age_s))
                self._waiting.append(event)
                continue
            if event.kind is EventKind.TAP:  # a tap is due at once, after the finger's earlier grooves
                due += [earlier for earlier in self._waiting if earlier.finger == event.finger]
                self._waiting = deque(later for later in self._waiting if later.finger != event.finger)
            due.append(event)
        if self._waiting:
            self._look_back(t_s)
            while self._waiting and t_s - self._waiting[0].hand_ns * 1e-9 >= self.behind_s - 1e-6:
                due.append(self._waiting.popleft())
        return due

    def clear(self) -> None:
        """Drop all waiting grooves."""
        self._waiting.clear()

    def _look_back(self, t_s: float) -> None:
        """Set the delay to the largest age in the last MEMORY_S, at most LONGEST_WAIT_S above the smallest."""
        ages = self._ages
        while ages and not t_s - MEMORY_S <= ages[0][0] <= t_s:
            ages.popleft()
        known = [age_s for _, age_s in ages]
        soonest_s = min(known, default=math.inf)
        self.behind_s = min(max(known, default=0.0), soonest_s + LONGEST_WAIT_S)
