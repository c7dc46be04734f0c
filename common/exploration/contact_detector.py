"""Detects contact of a finger from a noisy force: fast for a jump, without chatter for a light contact.

The force is averaged over samples that agree with the newest one (sigma filter, Lee 1983). A jump passes unchanged. A
slow change is delayed by half of the averaged time. Contact is detected after a short average, its end after a long
one.
"""

import math
from collections import deque

CONTACT_ON_N = 0.30
"""Force at which a contact begins, N."""
CONTACT_OFF_N = 0.15
"""Force below which a contact ends, N."""
FREE_N = 0.10
"""Force below which a finger is free, N: three times the noise where the noise is three times its usual level."""
SOON_S = 0.003
"""Averaging time of the force while free, s: one of 250 samples a second."""
SURE_S = 0.010
"""Averaging time of the force while touching, s: three of 250 samples a second."""
AGREES_N = 0.15
"""Maximum difference from the newest sample of the samples that are averaged, N."""
TAP_S = 0.15
"""Duration of a tap, s (T_t of Eq. 1)."""
BOUNCE_S = 0.030
"""Maximum time without contact in a bounce, s: a finger that left within a tap and returns sooner continues it."""
_ROUNDED_S = 1e-4
_LONGEST_S = SURE_S + _ROUNDED_S


class ContactDetector:
    """Contact of one finger, from its force.

    Attributes:
        touching: whether the finger touches.
        began: whether the last step began a contact; a bounce begins none.
        ended: whether the last step ended a contact, or left it for a bounce.
        began_s: start of the present or last contact, s.
        force_n: averaged force, N.
    """

    def __init__(self) -> None:
        self.touching = self.began = self.ended = False
        self.began_s = 0.0
        self.force_n = 0.0
        self._ended_s = -math.inf
        self._recent: deque[tuple[float, float]] = deque()

    def step(self, t_s: float, force_n: float) -> None:
        """Take the force at `t_s`, N; a value that is not finite counts as 0."""
        if not math.isfinite(force_n):
            force_n = 0.0
        recent = self._recent
        if recent and not t_s > recent[-1][0]:
            recent.clear()
        recent.append((t_s, force_n))
        while t_s - recent[0][0] > _LONGEST_S:
            recent.popleft()
        since_s = t_s - (SURE_S if self.touching else SOON_S) - _ROUNDED_S
        total_n, count = 0.0, 0
        for when_s, sample_n in reversed(recent):
            if when_s < since_s:
                break
            if -AGREES_N <= sample_n - force_n <= AGREES_N:
                total_n += sample_n
                count += 1
        mean_n = self.force_n = total_n / count
        self.began = self.ended = False
        if self.touching:
            if not mean_n >= CONTACT_OFF_N:
                self.touching, self.ended, self._ended_s = False, True, t_s
        elif mean_n >= CONTACT_ON_N:
            self.touching = True
            if not self._bounced(t_s):
                self.began, self.began_s = True, t_s

    def _bounced(self, t_s: float) -> bool:
        return 0.0 <= t_s - self._ended_s < BOUNCE_S and self._ended_s - self.began_s < TAP_S
