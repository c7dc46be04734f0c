"""Runs the loop of a site, the same for both: ticks on time, and a status once a second."""

import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from common.faults.texts import said_fault
from common.link.session_display import ENDED, shown_state
from common.runtime.containment import Containment
from common.runtime.periodic_loop import PeriodicLoop
from common.runtime.rate_monitor import RateMonitor, spent
from common.runtime.realtime_priority import RealtimePriority
from common.runtime.scheduling import become_timely
from common.runtime.status_file import StatusFile
from common.runtime.systemd_notify import Supervisor
from common.runtime.watchdog import LoopWatchdog
from common.timing.timeouts import NOTICE_S


class Site(Protocol):
    """A site that the loop runs."""

    @property
    def contain(self) -> Containment:
        """Containment of the site's exceptions."""

    def tick(self, now_ns: int) -> None:
        """Read, compute, pass the gate, write."""

    def figures(self) -> dict[str, object]:
        """Return the site's figures for the status file."""


def run_site_loop(
    site: Site,
    name: str,
    rate_hz: float,
    stop: Callable[[], bool],
    *,
    status: Path | None = None,
    each_second: Callable[[], None] = lambda: None,
    report: Callable[[int, dict[str, object]], None] = lambda now_ns, figures: None,
    clock_ns: Callable[[], int] = time.monotonic_ns,
    sleep: Callable[[float], None] = time.sleep,
    watchdog: Callable[[Callable[[], int]], AbstractContextManager[object]] = LoopWatchdog,
    supervisor: Supervisor | None = None,
    precedence: RealtimePriority | None = None,
) -> None:
    """Run `site` until `stop()`; its devices must be connected.

    Args:
        site: site to run; each tick gets the clock's time.
        name: name of the process, for its status file.
        rate_hz: ticks a second.
        stop: called before each tick.
        status: file that is rewritten once a second and at the end; None writes no file.
        each_second: called once a second before the figures are taken.
        report: called with the time of a tick and the figures once a second.
        clock_ns: monotonic clock, ns.
        sleep: waits for a time, s, on the same clock.
        watchdog: watches the number of ticks while the loop runs.
        supervisor: gets start, state and end of the loop; by default the supervisor that the environment names.
        precedence: gives the loop real-time priority while it deserves it; by default that of the system.
    """
    become_timely()
    loop = PeriodicLoop(1.0 / rate_hz, now=lambda: clock_ns() * 1e-9, sleep=sleep)
    held = RateMonitor(rate_hz)
    precedence = precedence or RealtimePriority()
    status_file = StatusFile(status, name, loop)
    contain = site.contain
    due_ns = None
    with supervisor or Supervisor() as notified, watchdog(lambda: loop.ticks):
        while not stop():
            loop.wait()
            now_ns = clock_ns()
            site.tick(now_ns)
            if due_ns is None:
                notified.ready()
            if due_ns is None or now_ns >= due_ns:
                due_ns = now_ns + round(NOTICE_S * 1e9)
                with contain.step("each second", latches=False):
                    each_second()
                figures: dict[str, object] = {"contained": dict(contain.places)}
                with contain.step("figures", latches=False):
                    figures |= {**site.figures(), **held.look(now_ns * 1e-9, spent(loop))}
                    figures["real_time"] = precedence.look(not held.behind, held.works)
                    status_file.write(now_ns * 1e-9, figures)
                    report(now_ns, figures)
                notified.alive(in_words(figures))
        ended_s = clock_ns() * 1e-9
        with contain.step("figures", latches=False):
            figures = {**site.figures(), **held.look(ended_s, spent(loop)), "real_time": precedence.first}
            figures["state"] = ENDED  # nothing updates this file from now on
            status_file.write(ended_s, figures)


def in_words(figures: Mapping[str, object]) -> str:
    """Return a site's state as one line, with its fault or its first problem."""
    problems = ("missing", "refusal", "stale", "behind")
    why = said_fault(figures.get("fault")) or next((figures[name] for name in problems if figures.get(name)), "")
    state = shown_state(str(figures.get("state", "running")), link_silent=bool(figures.get("stale")))
    return state + (f": {why}" if why else "")
