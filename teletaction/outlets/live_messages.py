"""Turns messages of the console's feed into named messages, as an export of the recording has them."""

from collections import Counter
from collections.abc import Callable, Sequence

from common.recording.clock_anchor import ClockAnchor
from operator_site.console.state.site_time import SiteTime
from operator_site.session.console_feed import STREAMS, Fed
from teletaction.export.named_recording import NamedMessage
from teletaction.export.topics import TOPICS

FED_TOPICS = tuple(topic for topic in TOPICS if topic in STREAMS)
"""Streams of the feed, in the order of TOPICS."""
STANDSTILL_S = 0.1
"""Change of the lead of the site's clock that shows a standstill of the host, s. Batches arrive within less."""


class LiveMessages:
    """Names the values of fed messages and converts their times. Pure: the time is an argument.

    The site's clock is this machine's monotonic clock plus all standstills of the host. A message gets times without
    them: of the monotonic clock, and of the wall clock by a pair of readings at the start. So a step of the wall clock
    changes nothing. After a standstill a new pair is read.

    Attributes:
        counts: number of readable messages of each stream.
        damaged: number of unreadable messages, which are dropped.
    """

    def __init__(self, read_clocks: Callable[[], ClockAnchor] = ClockAnchor.now):
        """Begin without messages; `read_clocks` reads this machine's clocks."""
        self.counts: Counter[str] = Counter()
        self.damaged = 0
        self._read_clocks = read_clocks
        self._anchor = read_clocks()
        self._site_time = SiteTime()

    def take(self, here_ns: int, fed: Sequence[Fed]) -> list[NamedMessage]:
        """Return the readable messages of the feed with their names; they arrived at `here_ns`, monotonic, ns."""
        if not fed:
            return []
        ahead_ns = self._ahead_ns(here_ns, fed[-1].time_ns)
        found = []
        for stream, time_ns, payload in fed:
            try:
                if stream not in STREAMS:
                    raise ValueError(f"no stream {stream!r}")
                fields = TOPICS[stream].read(payload)
            except ValueError:
                self.damaged += 1
                continue
            self.counts[stream] += 1
            monotonic_ns = time_ns - ahead_ns
            found.append(NamedMessage(stream, monotonic_ns, self._anchor.wall_time_ns(monotonic_ns), fields))
        return found

    def _ahead_ns(self, here_ns: int, time_ns: int) -> int:
        """Return the lead of the site's clock, ns, after a message with a time of that clock."""
        before_s = self._site_time.ahead_s
        self._site_time.heard(here_ns * 1e-9, time_ns * 1e-9)
        if abs(self._site_time.ahead_s - before_s) > STANDSTILL_S:
            self._anchor = self._read_clocks()
        return round(self._site_time.ahead_s * 1e9)
