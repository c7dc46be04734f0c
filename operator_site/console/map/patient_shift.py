"""Notices that the patient has moved: repeated touches meet the surface at another height than before.

Each contact that rests on known ground is compared with the older contacts around it. A plane through these gives the
height that is expected there. The spread of the differences is measured, so that breathing and a rough surface count as
usual. A run of contacts that all lie too high or too low is a movement along the normal. Differences that are too large
and have no common sign are a turn or a movement sideways over a curved surface. A movement sideways over a flat surface
changes no height, and is not noticed.
"""

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGER_Y_M, FINGERS
from common.wire.messages import STIFFNESS_KNOWN_LN_SD, TouchRow
from operator_site.console.map.finger_samples import STILL_M

Floats = NDArray[np.float64]
NEAR_M = 0.012
"""Largest distance of the contacts that give the expected height, m."""
AGAIN_M = 0.010
"""Largest distance of the nearest one of them, m."""
FEWEST_NEAR = 4
"""Number of contacts from which a plane is put through their heights; of fewer, the nearest one counts."""
SAME_M = 0.003
"""Largest distance of that nearest one, m."""
RECENT = 10
"""Number of the newest compared contacts among which a movement is sought."""
FEWEST = 3
"""Least number of contacts of a movement."""
LEAST_M = 0.001
"""Smallest movement that counts, m."""
USUAL_SPREAD_M, USUAL_COUNT = 0.001, 12
"""Spread of the differences before it is measured, m, and the number of differences that it counts for."""
SURE = 4.5
"""Size of a movement in standard deviations from which it is noticed."""
ALIKE = 0.4
"""Largest median difference of the contacts of one movement along the normal, as a share of it."""
MOST_CONTACTS = 1000
"""Number of contacts that are kept."""
_MEDIAN_SD = 1.25
"""Standard deviation of a median of many numbers, times the root of their number, in their standard deviations."""


class Contact(NamedTuple):
    """One contact of a resting finger: time, s, its place, and the height of the undeformed surface there, m."""

    t_s: float
    x_m: float
    y_m: float
    z_m: float


class Movement(NamedTuple):
    """A movement of the patient.

    Attributes:
        since_s: time of the first contact that shows it, s.
        by_m: movement along the normal, m, positive towards the hand; None for a turn or a movement sideways.
        contacts: number of contacts that show it.
    """

    since_s: float
    by_m: float | None
    contacts: int


class _Compared(NamedTuple):
    contact: Contact
    above_m: float
    """Height above the expected one, m."""
    higher_m: float
    """The same, divided by the growth of its spread with that of the expected height, m."""


class PatientShift:
    """Watches the contacts of a session. Pure; it can be pickled.

    Attributes:
        movement: the newest movement; None before the first.
        compared: number of compared contacts.
    """

    def __init__(self) -> None:
        self.movement: Movement | None = None
        self.compared = 0
        self._known: deque[Contact] = deque(maxlen=MOST_CONTACTS)
        self._recent: deque[_Compared] = deque()
        self._usual: deque[float] = deque(maxlen=10 * RECENT)
        self._resting: list[Contact | None] = [None] * len(FINGERS)
        self._from_m: list[tuple[float, float] | None] = [None] * len(FINGERS)

    def step(self, t_s: float, rows: Sequence[TouchRow]) -> Movement | None:
        """Take the touch rows of an accepted packet at a time, s; return a movement that is noticed with it."""
        noticed = None
        for finger, row in enumerate(rows):
            if row.contact == 0.0:
                contact, self._resting[finger], self._from_m[finger] = self._resting[finger], None, None
                if contact is not None:
                    noticed = self.take(contact) or noticed
                continue
            place = row.x_m, row.y_m + FINGER_Y_M[finger]
            began = self._from_m[finger]
            if began is None:
                self._from_m[finger] = began = place
            if math.dist(began, place) > STILL_M:  # a stroke
                self._resting[finger], self._from_m[finger] = None, (math.inf, math.inf)
            elif row.stiffness_n_m > 0.0 and row.stiffness_ln_sd < STIFFNESS_KNOWN_LN_SD:
                self._resting[finger] = Contact(t_s, *place, row.surface_z_m)
        return noticed

    def take(self, contact: Contact) -> Movement | None:
        """Take one contact that has ended; return a movement that is noticed with it."""
        expected = self._expected(contact)
        if expected is None:
            self._known.append(contact)
            return None
        self.compared += 1
        height_m, share = expected
        above_m = contact.z_m - height_m
        self._recent.append(_Compared(contact, above_m, above_m / share))
        movement = self._moved()
        if movement is not None:
            self._restart(movement)
        elif len(self._recent) > RECENT:
            oldest = self._recent.popleft()
            self._known.append(oldest.contact)
            self._usual.append(oldest.higher_m)
        return movement

    def _expected(self, contact: Contact) -> tuple[float, float] | None:
        """Return the height at a contact by those before, m, and by how much its spread exceeds that of a contact."""
        x_m, y_m = contact.x_m, contact.y_m
        near = [
            (k.x_m - x_m, k.y_m - y_m, k.z_m) for k in self._known if math.dist((k.x_m, k.y_m), (x_m, y_m)) <= NEAR_M
        ]
        far_m = [math.hypot(dx_m, dy_m) for dx_m, dy_m, _ in near]
        if not near or min(far_m) > AGAIN_M:
            return None
        known = np.array(near)
        ones = np.column_stack([np.ones(len(near)), known[:, :2]])
        if len(near) >= FEWEST_NEAR and np.linalg.matrix_rank(ones, tol=0.01) == 3:
            plane, *_ = np.linalg.lstsq(ones, known[:, 2], rcond=None)
            leverage = float(np.linalg.inv(ones.T @ ones)[0, 0])
            return (float(plane[0]), math.sqrt(1.0 + leverage)) if leverage <= 1.0 else None
        if min(far_m) > SAME_M:
            return None
        return near[far_m.index(min(far_m))][2], math.sqrt(2.0)

    def _moved(self) -> Movement | None:
        """Return the movement that the newest contacts show; None while there is none."""
        recent = np.array([(each.above_m, each.higher_m) for each in self._recent])
        spread_m = self._spread_m()
        for count in range(FEWEST, len(recent) + 1):
            above_m, newest_m = recent[-count:].T
            since_s = self._recent[-count].contact.t_s
            median_m = float(np.median(newest_m))
            if abs(newest_m[0]) < 0.5 * max(LEAST_M, abs(median_m)):
                continue  # a movement begins with a contact that shows it
            if abs(median_m) >= LEAST_M and abs(median_m) * math.sqrt(count) >= SURE * _MEDIAN_SD * spread_m:
                alike = float(np.median(np.abs(newest_m - median_m))) <= max(spread_m, ALIKE * abs(median_m))
                return Movement(since_s, float(np.median(above_m)) if alike else None, count)
            # Of one outlier, only as much counts as of two: a single wrong height is no movement.
            sizes_m = np.sort(np.abs(newest_m))[:-1]
            excess = float((sizes_m**2).sum() / spread_m**2 - sizes_m.size) / math.sqrt(2.0 * sizes_m.size)
            if float(np.median(sizes_m)) >= LEAST_M and excess >= 2.0 * SURE:
                return Movement(since_s, None, count)
        return None

    def _spread_m(self) -> float:
        squares_m2 = USUAL_COUNT * USUAL_SPREAD_M**2 + sum(higher_m**2 for higher_m in self._usual)
        return math.sqrt(squares_m2 / (USUAL_COUNT + len(self._usual)))

    def _restart(self, movement: Movement) -> None:
        """Keep only the contacts since a movement."""
        self.movement = movement
        after = [each.contact for each in self._recent if each.contact.t_s >= movement.since_s]
        later = [contact for contact in self._known if contact.t_s >= movement.since_s]
        self._known = deque(sorted([*later, *after]), maxlen=MOST_CONTACTS)
        self._recent.clear()
