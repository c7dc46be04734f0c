"""Limits the speed of the remote hand's approach to the operator's hand after a release.

The operator's hand may have moved anywhere while the outputs were stopped. Set-points start at the remote hand and
close the distance at the approach speed. No finger is lowered before the hand is over the wanted place. A set-point
that has met its wanted value follows at full speed, which is reached gradually.
"""

WIDEN_M_S2 = 1.0
"""Growth rate of the speed limit after the set-point has met the wanted value, m/s2."""
MET_M = 1e-6
"""Maximum distance at which a set-point counts as having met the wanted value, m."""


class ApproachLimiter:
    """The speed limit of one set-point.

    Attributes:
        limit_m_s: present speed limit, m/s.
        met: whether the set-point has met the wanted value since its release.
        settled: whether it has met and the limit is the full speed; then a step changes nothing.
    """

    __slots__ = ("_approach_m_s", "_full_m_s", "limit_m_s", "met", "settled")

    def __init__(self, approach_m_s: float, full_m_s: float) -> None:
        """Begin with an approach.

        Args:
            approach_m_s: speed limit until the set-point has met the wanted value, m/s.
            full_m_s: final speed limit, m/s.
        """
        self._approach_m_s, self._full_m_s = approach_m_s, full_m_s
        self.let_go()

    def let_go(self) -> None:
        """Begin an approach."""
        self.limit_m_s, self.met, self.settled = self._approach_m_s, False, False

    def step(self, dt_s: float, left_m: float) -> None:
        """Take the distance that is left to the wanted value after this tick, m."""
        self.met = self.met or left_m <= MET_M
        if self.met:
            self.limit_m_s = min(self._full_m_s, self.limit_m_s + WIDEN_M_S2 * dt_s)
            self.settled = self.limit_m_s == self._full_m_s
