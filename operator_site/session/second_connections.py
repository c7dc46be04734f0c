"""Decides whether motion and touch have second connections: on a long way that loses packets, and has room for them."""

from collections import deque
from dataclasses import dataclass, field

FAR_NS = 20_000_000
"""Round trip beyond which repairing a lost packet is felt, ns."""
LATE = 1.8
"""Round trip of a late heartbeat, as a multiple of the shortest one: repairing a lost packet takes another one."""
LATE_BEATS, LATE_WITHIN_NS = 3, 60_000_000_000
"""Number of late heartbeats within a time, ns, that show loss. With 1 % of lost packets they take some 8 s."""
_BEATS = 20
"""Number of heartbeats, one second of them, that judge a way with second connections."""
_THIN, _THIN_NS = 2.0, 20_000_000
"""Increase of their shortest round trip, as a factor and a constant, ns, that shows a way without room for two."""


@dataclass(slots=True)
class SecondConnections:
    """Time is an argument, ns.

    Attributes:
        wanted: whether motion and touch shall have second connections.
        too_thin: whether the way had no room for them; then they are not tried again.
    """

    wanted: bool = False
    too_thin: bool = False
    _late_ns: deque[int] = field(default_factory=lambda: deque(maxlen=LATE_BEATS))
    """Times of the last late heartbeats."""
    _before_ns: int = 0
    """Shortest round trip before second connections were wanted, ns."""
    _with_ns: deque[int] = field(default_factory=lambda: deque(maxlen=_BEATS))
    """Last round trips since then, ns."""

    def heard(self, now_ns: int, round_trip_ns: int, shortest_ns: int) -> None:
        """Take an answer to a heartbeat.

        Args:
            now_ns: this site's clock, ns.
            round_trip_ns: time that the heartbeat and its answer were on their way, ns.
            shortest_ns: the shortest of the last seconds, ns.
        """
        if self.wanted:
            self._with_ns.append(round_trip_ns)
            if len(self._with_ns) == _BEATS and min(self._with_ns) > _THIN * self._before_ns + _THIN_NS:
                self.wanted, self.too_thin = False, True
        elif shortest_ns > FAR_NS and round_trip_ns > LATE * shortest_ns and not self.too_thin:
            self._late_ns.append(now_ns)
            if len(self._late_ns) == LATE_BEATS and now_ns - self._late_ns[0] <= LATE_WITHIN_NS:
                self.wanted, self._before_ns = True, shortest_ns
