"""Detects standstills of this host, in which its clock stood still while devices and people continued.

A suspended host stops CLOCK_MONOTONIC. A paused virtual machine also stops CLOCK_BOOTTIME. `HostClock` includes
suspends by itself, and the clocks of devices, which did not stop, set it forward after a pause. Every age and gap is
then true, and each guard acts as after a stopped process.
"""

import logging
import math
import time
from collections.abc import Callable, Sequence

from common.timing.timeouts import FRAME_S, STANDSTILL_S

log = logging.getLogger(__name__)

DRIFT = 0.05
"""Maximum relative drift of a device's clock against the host's (duty S10)."""
LONGEST_STEP_S = 0.1
"""Maximum time between two reports that counts for the drift, s: a late line is no slow clock."""
PACE_S = 1.0
"""Time over which the rate of a device's clock is measured, s."""
BEHIND_S = 1.0
"""Maximum lag of a device's clock, s; at more, the device restarted, its line is late, or the host's clock was set
forward."""
FOLLOWS_S = 0.030
"""Maximum device time between two reports that follow each other, s."""
BELIEVED_S = 2.0
"""Time after which a lag of a device's clock is accepted as its new reference, s."""
_WRAPS = 1 << 32
_COMPARISONS = 20
"""Number of comparisons of two clocks: a process may lose its processor for milliseconds between two readings."""


def since_boot_ns() -> Callable[[], int]:
    """Return a clock that continues in a suspend, ns; it starts at the reading of CLOCK_MONOTONIC."""
    ahead_ns = _ahead_ns(time.monotonic_ns, lambda: time.clock_gettime_ns(time.CLOCK_BOOTTIME))
    return lambda: time.clock_gettime_ns(time.CLOCK_BOOTTIME) - ahead_ns


def _ahead_ns(one_ns: Callable[[], int], other_ns: Callable[[], int]) -> int:
    """Return how far the other clock is ahead, ns, from the fastest of several comparisons."""
    found = []
    for _ in range(_COMPARISONS):
        before_ns, between_ns, after_ns = one_ns(), other_ns(), one_ns()
        found.append((after_ns - before_ns, between_ns - (before_ns + after_ns) // 2))
    return min(found)[1]


class HostClock:
    """The clock of one site: never behind the time that this host's devices show.

    Attributes:
        stood_still_s: total time by which it was set forward, s.
    """

    def __init__(self, read_ns: Callable[[], int] | None = None) -> None:
        """Read `read_ns`, ns; by default CLOCK_MONOTONIC with suspends included."""
        self.stood_still_s = 0.0
        self._read_ns = since_boot_ns() if read_ns is None else read_ns
        self._forward_ns = 0

    def now_ns(self) -> int:
        """Return the time, ns."""
        return self._read_ns() + self._forward_ns

    def now_s(self) -> float:
        """Return the time, s."""
        return (self._read_ns() + self._forward_ns) * 1e-9

    def put_forward(self, standstill_s: float) -> int:
        """Add a standstill that devices have shown, s, above 0; return it in ns."""
        forward_ns = round(standstill_s * 1e9)
        self._forward_ns += forward_ns
        self.stood_still_s += standstill_s
        log.warning("the host stood still for %.3f s together with its clock, while devices continued", standstill_s)
        return forward_ns


class Witness:
    """Compares one device's clock with the host's. Pure: both times are arguments, s.

    A report may be late, but never early. The device's lead over the host is therefore highest for a report without
    delay. A lead above that value is time that the host did not count. The highest value falls as fast as a slow clock
    lags. A lead that falls faster than DRIFT belongs to a late line and will return. After a standstill the lead rises
    in one step with the next report; a device that catches up raises it in several steps.

    A site that starts, or that a busy machine holds back, reads its backlog in pieces. The usual lead is not updated
    before the backlog is read, because all reports in it are late.

    A standstill counts only where reports cover it: a device keeps reporting while the host stands still. A simulated
    device that was held back skips time instead, and no reports cover the skipped time.
    """

    def __init__(self) -> None:
        self._lead_s: float | None = None
        self._newest_s = 0.0
        self._host_s = 0.0
        self._device_us = 0
        self._device_s = 0.0
        self._behind_since_s: float | None = None
        self._fall = DRIFT
        """Rate at which the lead of a report without delay falls, s/s; DRIFT until it is measured."""
        self._window_s = self._best_s = 0.0
        self._before: tuple[float, float] | None = None

    def report(self, host_s: float, device_us: Sequence[int], *, drained: bool = True) -> float:
        """Take the waiting reports of a serial module; return the standstill that they show, s, mostly 0.

        Args:
            host_s: host time after they were read, s. An earlier time would look like a standstill.
            device_us: device time in each report, one or more, us modulo 2^32.
            drained: whether no more reports wait.
        """
        reported_s = 0.0
        for each_us in device_us:
            since_s = ((each_us - self._device_us + _WRAPS // 2) % _WRAPS - _WRAPS // 2) * 1e-6
            self._device_us = each_us
            self._device_s += since_s
            reported_s += since_s if 0.0 < since_s <= FOLLOWS_S else 0.0
        return self._step(host_s, reported_s, drained)

    def frames(self, host_s: float, count: int, *, drained: bool = True) -> float:
        """Take the number of all frames of FRAME_S read from a CAN node; return the standstill that it shows, s.

        They were read until `host_s`, s, by all connections; `drained` if no more wait.
        """
        before_s, self._device_s = self._device_s, count * FRAME_S
        return self._step(host_s, self._device_s - before_s, drained)

    def _step(self, host_s: float, reported_s: float, drained: bool) -> float:
        """Compare the device's time with the host's; reports cover `reported_s` of it, s."""
        lead_s = self._device_s - host_s
        if self._lead_s is None:
            if drained:
                self._lead_s, self._host_s = lead_s, host_s
                self._newest_s = lead_s
                self._window_s, self._best_s = host_s, lead_s
            return 0.0
        if host_s < self._host_s:
            reported_s = math.inf  # a clock that was set back is sufficient evidence
        passed_s = host_s - self._host_s
        if not 0.0 <= passed_s <= LONGEST_STEP_S:
            passed_s = min(LONGEST_STEP_S, max(0.0, passed_s))
        usual_s = self._lead_s - self._fall * passed_s
        jump_s, self._newest_s = lead_s - self._newest_s, lead_s
        if lead_s - usual_s > STANDSTILL_S and jump_s > STANDSTILL_S and reported_s > STANDSTILL_S:
            self._lead_s, self._host_s = usual_s, host_s  # the clock is set forward, so the lead is usual again
            return lead_s - usual_s
        if not drained:
            return 0.0
        self._lead_s, self._host_s = usual_s if usual_s >= lead_s else lead_s, host_s
        if not 0.0 <= host_s - self._window_s < PACE_S:
            self._measure(host_s, lead_s)
        elif lead_s > self._best_s:
            self._best_s = lead_s
        if lead_s >= usual_s - BEHIND_S:
            self._behind_since_s = None
        elif self._behind_since_s is None:
            self._behind_since_s = host_s
        elif host_s - self._behind_since_s > BELIEVED_S:
            self._lead_s, self._behind_since_s = lead_s, None
        return 0.0

    def _measure(self, host_s: float, lead_s: float) -> None:
        """At the end of a PACE_S window, compare its best lead with that of the window before."""
        if self._before is not None and self._window_s > self._before[0]:
            began_s, best_s = self._before
            fall = (best_s - self._best_s) / (self._window_s - began_s)
            if abs(fall) <= 1.02 * DRIFT:
                self._fall = max(0.0, fall)
        self._before = self._window_s, self._best_s
        self._window_s, self._best_s = host_s, lead_s
