"""Plays the grooves of a patterned surface: when each is due, and its impulse J(t) (Kron & Schmidt 2003, section 3.1).

Each groove carries the time at which the operator's hand was there, on the operator's clock. Played on arrival, the
grooves that a lost packet held up would come in a burst, and a regular grating would feel irregular. So each groove
waits until its age reaches the largest recent age, which keeps its spacing to its neighbours.

Impulses are played one by one as far as motor and finger can resolve them. Faster ones are replaced by a constant
speed with the same mean.
"""

import math
from collections import deque
from collections.abc import Iterable

from common.limits import MOTOR_MAX_RPM
from common.wire.messages import Event, EventKind
from operator_site.vibration.motor_drive import RPM_TO_RAD_S

DECAY_PER_S = 60.0
"""Decay rate of impulses without one in the surface model, 1/s."""
FOLD_ABOVE_HZ = 20.0
"""Rate of grooves above which they are folded into their mean speed, Hz."""
APART_BELOW_HZ = 15.0
"""Rate of grooves below which folded ones are played one by one again, Hz."""
OVER_S = 2.0 / APART_BELOW_HZ
"""Time without a groove after which the pattern has ended, s."""
LONGEST_WAIT_S = 0.040
"""Longest added delay of a groove, s; a larger delay changes the perceived texture (Okamoto et al. 2009)."""
OLDEST_S = 1.0
"""Largest plausible age of a groove, s; an older one, or one from the future, is played at once."""
MEMORY_S = 3.0
"""Time for which the age of a groove is remembered, s."""
MOST_WAITING = 512
"""Maximum number of delayed grooves; the oldest of more are dropped. Five fingers cross at most 375 in a second."""
_NEVER_NS = -(10**18)


class Grooves:
    """The pattern under one finger.

    Attributes:
        rad_s: present addition to the motor's speed, rad/s.
        folded: whether the addition is a mean.
    """

    def __init__(self) -> None:
        self.rad_s = 0.0
        self.folded = False
        self._t_s = -math.inf
        self._came_s = -math.inf
        self._crossed_ns = _NEVER_NS
        self._gap_s = math.inf

    def end(self) -> None:
        """End the pattern, because the finger no longer strokes."""
        self.rad_s, self.folded, self._crossed_ns, self._gap_s = 0.0, False, _NEVER_NS, math.inf

    def step(self, t_s: float, decay_per_s: float) -> None:
        """Let impulses decay until `t_s` at their surface's rate, or at DECAY_PER_S if that is 0."""
        before_s, self._t_s = self._t_s, t_s
        if self.folded and t_s - self._came_s > OVER_S:
            self.end()
        if self.rad_s and not self.folded:
            # A sum of equal exponentials decays as one: J(t) needs a single number.
            self.rad_s *= math.exp(-(decay_per_s or DECAY_PER_S) * max(0.0, t_s - before_s))

    def cross(self, amplitude_rad_s: float, time_ns: int, decay_per_s: float) -> None:
        """Add a crossed groove.

        Args:
            amplitude_rad_s: amplitude of its impulse, rad/s.
            time_ns: time of the crossing on the clock of its site, ns; grooves may arrive in bursts.
            decay_per_s: decay rate of its impulse, 1/s; 0 for DECAY_PER_S.
        """
        gap_s, self._crossed_ns = 1e-9 * (time_ns - self._crossed_ns), time_ns
        known = 0.0 < gap_s < OVER_S
        # Average two gaps, so that one early groove does not count as a fast train.
        rate_hz = 2.0 / (gap_s + self._gap_s) if known else 0.0
        self._gap_s = gap_s if known else math.inf
        self._came_s = self._t_s
        self.folded = rate_hz > (APART_BELOW_HZ if self.folded else FOLD_ABOVE_HZ)
        amplitude = max(0.0, amplitude_rad_s)
        mean = amplitude * rate_hz / (decay_per_s or DECAY_PER_S)
        self.rad_s = min(MOTOR_MAX_RPM * RPM_TO_RAD_S, mean if self.folded else self.rad_s + amplitude)


class GrooveTiming:
    """Delays grooves until they are due; all other events pass at once.

    Attributes:
        behind_s: present delay of grooves behind the hand, s.
    """

    def __init__(self) -> None:
        self.behind_s = 0.0
        self._oldest: deque[tuple[float, float]] = deque()
        self._youngest: deque[tuple[float, float]] = deque()
        """Arrival times, s, and ages, s, of grooves; without ages that a later one exceeds, or undercuts."""
        self._waiting: deque[Event] = deque(maxlen=MOST_WAITING)

    @property
    def waits(self) -> bool:
        """Whether any groove is delayed."""
        return bool(self._waiting)

    def step(self, t_s: float, fresh: Iterable[Event]) -> list[Event]:
        """Return the events due at `t_s`, s of the operator's clock, in the order in which they happened."""
        due = []
        for event in fresh:
            age_s = t_s - event.hand_ns * 1e-9
            if event.kind is EventKind.GROOVE and 0.0 <= age_s <= OLDEST_S:
                _add(self._oldest, t_s, age_s, 1.0)
                _add(self._youngest, t_s, age_s, -1.0)
                self._waiting.append(event)
                continue
            if event.kind is EventKind.TAP:  # a tap is due at once, after the finger's earlier grooves
                due += [earlier for earlier in self._waiting if earlier.finger == event.finger]
                others = [later for later in self._waiting if later.finger != event.finger]
                self._waiting = deque(others, maxlen=MOST_WAITING)
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
        for ages in (self._oldest, self._youngest):
            while ages and not t_s - MEMORY_S <= ages[0][0] <= t_s:
                ages.popleft()
        if self._oldest:
            self.behind_s = min(self._oldest[0][1], self._youngest[0][1] + LONGEST_WAIT_S)
        else:
            self.behind_s = 0.0


def _add(ages: deque[tuple[float, float]], t_s: float, age_s: float, sign: float) -> None:
    """Add an age, s, to those of which the first is the largest (sign 1) or the smallest (-1)."""
    while ages and sign * ages[-1][1] <= sign * age_s:
        ages.pop()
    ages.append((t_s, age_s))
