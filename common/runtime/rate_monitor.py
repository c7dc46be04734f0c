"""Whether a loop holds its rate, and what keeps it from that: its own work, or waiting for a processor."""

import logging
import time
from collections import deque
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from common.runtime.periodic_loop import PeriodicLoop

log = logging.getLogger(__name__)

HELD = 0.95
"""Share of the ticks that makes a rate held. A loop that stood still for 0.2 s still holds it."""
HELD_AGAIN = 0.98
WINDOW_S = 5.0


class Spent(NamedTuple):
    """What a loop has done so far.

    Attributes:
        ticks: made.
        worked_s: processor time of its thread.
        waited_s: for which its thread was ready, and another had the processor; None where the system does not tell.
    """

    ticks: int
    worked_s: float
    waited_s: float | None


class RateMonitor:
    """Looks at a loop once a second, over the last WINDOW_S. Pure: times are arguments, s.

    Attributes:
        behind: why the rate is not held, in words; empty while it is, and in the first WINDOW_S.
        works: share of the time that the loop's thread works; None in the first WINDOW_S.
    """

    def __init__(self, rate_hz: float) -> None:
        self._wanted_hz = rate_hz
        self._looks: deque[tuple[float, Spent]] = deque()
        self._behind_s = 0.0
        self.behind = ""
        self.works: float | None = None

    def look(self, now_s: float, spent: Spent) -> dict[str, object]:
        """What the status tells: ticks a second, `wanted_hz`, `works`, `behind`, and for how long it was behind in all.

        The log has when it is so and when no more.
        """
        if self.behind:
            self._behind_s += now_s - self._looks[-1][0]
        self._looks.append((now_s, spent))
        while len(self._looks) > 2 and now_s - self._looks[1][0] >= WINDOW_S:
            self._looks.popleft()
        then_s, then = self._looks[0]
        seconds = now_s - then_s
        rate_hz = None if seconds <= 0.0 else (spent.ticks - then.ticks) / seconds
        if rate_hz is not None and seconds >= WINDOW_S:
            self._judge(rate_hz, seconds, then, spent)
        return {
            "rate_hz": None if rate_hz is None else round(rate_hz, 1),
            "wanted_hz": self._wanted_hz,
            "works": None if self.works is None else round(self.works, 3),
            "behind": self.behind,
            "behind_s": round(self._behind_s, 1),
        }

    def _judge(self, rate_hz: float, seconds: float, then: Spent, now: Spent) -> None:
        works = self.works = (now.worked_s - then.worked_s) / seconds
        was_behind = bool(self.behind)
        held = rate_hz >= (HELD_AGAIN if was_behind else HELD) * self._wanted_hz
        self.behind = ""
        if not held:
            self.behind = f"{rate_hz:.0f} of {self._wanted_hz:g} ticks a second; it works {works:.0%} of the time"
            if now.waited_s is not None and then.waited_s is not None:
                waits = (now.waited_s - then.waited_s) / seconds
                self.behind += f" and waits for a processor {waits:.0%}"
        if held and was_behind:
            log.info("the loop holds its %g ticks a second again", self._wanted_hz)
        elif not held and not was_behind:
            log.warning("the loop is behind: %s", self.behind)


def spent(loop: PeriodicLoop) -> Spent:
    """What this thread's loop has done so far."""
    waited_s = None
    with suppress(OSError, ValueError, IndexError):  # a system that does not count it
        waited_s = int(Path("/proc/thread-self/schedstat").read_bytes().split()[1]) * 1e-9
    return Spent(loop.ticks, time.thread_time(), waited_s)
