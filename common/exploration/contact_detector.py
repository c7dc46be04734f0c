"""Whether a finger touches, from a noisy force: at once where the force jumps, without chatter where a finger grazes.

The force is averaged, but only over samples that agree with the newest one (a sigma filter, Lee 1983): a jump passes
unchanged, a slow change comes half of the averaged time late. To touch must be told soon, to have left must be sure.
"""

import math
from collections import deque

CONTACT_ON_N = 0.30
CONTACT_OFF_N = 0.15
"""Contact begins at the first and ends below the second, N."""
FREE_N = 0.10
"""Below this nothing is touched yet, N: three times the force's noise where that is three times its usual."""
SOON_S = 0.003
SURE_S = 0.010
"""The force is averaged over this time while free, and while touching, s: one and three of 250 samples a second."""
AGREES_N = 0.15
"""As far as samples are so near the newest one, N."""
TAP_S = 0.15
"""How long a tap is a tap, s (T_t of Eq. 1)."""
BOUNCE_S = 0.030
"""A finger that left within a tap and is back after less than this has bounced: it is still the same tap."""
_ROUNDED_S = 1e-4
_LONGEST_S = SURE_S + _ROUNDED_S


class ContactDetector:
    """Contact of one finger.

    Attributes:
        touching: whether it touches.
        began: whether the last step began a contact; a bounce begins none.
        ended: whether the last step ended a contact, or left it for a bounce.
        began_s: when the present (or last) contact began, s.
        force_n: the force without its noise, N.
    """

    __slots__ = ("_ended_s", "_recent", "began", "began_s", "ended", "force_n", "touching")

    def __init__(self) -> None:
        self.touching = self.began = self.ended = False
        self.began_s = 0.0
        self.force_n = 0.0
        self._ended_s = -math.inf
        self._recent: deque[tuple[float, float]] = deque()

    def step(self, t_s: float, force_n: float) -> None:
        """Take the force at `t_s`, N; not finite counts as none."""
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
