"""How the remote hand comes to the operator's hand when it is let go: slowly, until it has met it once.

While nothing acted the operator's hand may have gone anywhere. The set-points begin where the remote hand is, close the
distance at the approach speed, and no finger is lowered before the hand is over the place that is meant. What has met
follows at full speed, which is reached gradually.
"""

WIDEN_M_S2 = 1.0
"""How fast the speed limit grows once the hand is met, m/s per s."""
MET_M = 1e-6


class ApproachLimiter:
    """The speed limit of one set-point.

    Attributes:
        limit_m_s: the present one.
        met: whether the set-point has been where it is wanted since it was let go.
        settled: whether it has met and is at full speed: then a step changes nothing.
    """

    __slots__ = ("_approach_m_s", "_full_m_s", "limit_m_s", "met", "settled")

    def __init__(self, approach_m_s: float, full_m_s: float) -> None:
        """Not let go yet.

        Args:
            approach_m_s: the limit until it has met.
            full_m_s: the limit in the end.
        """
        self._approach_m_s, self._full_m_s = approach_m_s, full_m_s
        self.let_go()

    def let_go(self) -> None:
        """Begin to approach."""
        self.limit_m_s, self.met, self.settled = self._approach_m_s, False, False

    def step(self, dt_s: float, left_m: float) -> None:
        """Take how far from what is wanted the set-point has stayed in this tick, m."""
        self.met = self.met or left_m <= MET_M
        if self.met:
            self.limit_m_s = min(self._full_m_s, self.limit_m_s + WIDEN_M_S2 * dt_s)
            self.settled = self.limit_m_s == self._full_m_s
