"""Measures whether a loop holds its rate, and how much of the time it works or waits for a processor."""

import logging
import time
from collections import deque
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from common.runtime.periodic_loop import PeriodicLoop

log = logging.getLogger(__name__)

HELD = 0.95
"""Minimum share of its ticks that a loop makes while it holds its rate; a standstill of 0.2 s is permitted."""
HELD_AGAIN = 0.98
"""Minimum share of its ticks with which a loop that was behind holds its rate again."""
WINDOW_S = 5.0
"""Length of the window over which a rate is measured, s."""


class Spent(NamedTuple):
    """Work of a loop since its start.

    Attributes:
        ticks: number of ticks.
        worked_s: processor time of its thread, s.
        waited_s: time for which its thread was ready while another had the processor, s; None where the system does
            not report it.
    """

    ticks: int
    worked_s: float
    waited_s: float | None


class RateMonitor:
    """Measures a loop once a second, over the last WINDOW_S. Pure: times are arguments, s.

    Attributes:
        behind: description of a rate that is not held; empty while it is held, and in the first WINDOW_S.
        works: share of the time that the loop's thread works; None in the first WINDOW_S.
    """

    def __init__(self, rate_hz: float) -> None:
        self._wanted_hz = rate_hz
        self._looks: deque[tuple[float, Spent]] = deque()
        self._behind_s = 0.0
        self.behind = ""
        self.works: float | None = None

    def look(self, now_s: float, spent: Spent) -> dict[str, object]:
        """Return the figures for the status: ticks a second, `wanted_hz`, `works`, `behind` and total time behind, s.

        The log states when the loop falls behind and when it holds its rate again.
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
    """Return the work of this thread's loop since its start."""
    waited_s = None
    with suppress(OSError, ValueError, IndexError):  # the system does not count it
        waited_s = int(Path("/proc/thread-self/schedstat").read_bytes().split()[1]) * 1e-9
    return Spent(loop.ticks, time.thread_time(), waited_s)
