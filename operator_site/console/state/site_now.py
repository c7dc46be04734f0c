"""Keeps the state of the operator site: session, link, devices and recording, from its feed and its local control."""

import math
from collections import deque
from collections.abc import Mapping
from itertools import takewhile
from typing import Any

from common.faults.fault import STOPS, Fault, FaultCode, read_fault
from common.fingers import FINGERS
from common.limits import GAP_S
from common.link.session_display import (
    CONNECTED,
    DISCONNECTED,
    ENGAGED,
    ENGAGING,
    FAULT,
    LOST,
    PAUSED,
    Source,
    shown_state,
)
from common.link.session_state import Happening
from common.timing.timeouts import REFRESH_S
from common.wire.messages import Touch
from common.wire.noted_consent import NotedConsent
from common.wire.packets import LinkState
from common.wire.roughness_um import RoughnessUm
from operator_site.console import texts
from operator_site.console.state.bus_now import BusNow
from operator_site.coupling.coupling import DIRECT, Coupling, Places, edges
from operator_site.session.emergency_stop import REMOTE
from operator_site.session.remote_status import RemotePatient, remote_patient

SILENT_S = 0.5
"""Longest silence of the site, s; after it the shown values are not live."""
LATE_S = 1.5 * REFRESH_S
"""Time by which the next touch packet is due, s; a packet that a newer one replaces earlier is not lost."""
_OVERTAKEN_S = 2.0
"""Largest age of an overtaken report, s; an older one shows that the site's clock was restarted."""
_ENGAGED_HERE = (ENGAGING, LOST)
"""Reported states of a site that is engaged while the remote site is not engaged or is silent."""
_ROUNDING_S = 1e-3
"""Largest rounding error of a time, s."""
_DELAY_WINDOW_S = 1.0
"""Window of the mean delay, s."""
_LOSS_WINDOW_S = 10.0
"""Window of the loss, s."""
DEVICES = (*FINGERS, "exoskeleton", REMOTE)
"""Readable names of all devices."""


def _age_s(now_s: float, at_s: float) -> float:
    """Return the age of a message, s; a time up to _ROUNDING_S ahead counts as now."""
    age_s = now_s - at_s
    return 0.0 if -_ROUNDING_S < age_s < 0.0 else age_s


def device_named(name: str) -> str:
    """Return the readable name of a device in the site's figures, such as `ring` for `ring tacttip`."""
    return REMOTE if name == "telemanipulator" else name.removesuffix(" tacttip")


class LinkNow:
    """Measures delay, age and loss of touch packets. Pure: time is an argument, s.

    Attributes:
        clock: offset of the remote site's clock from the operator site's and its uncertainty, ns; None while unknown.
    """

    def __init__(self) -> None:
        self.clock: tuple[int, int] | None = None
        self._offset_ns = 0
        self._touch_s = -math.inf
        self._delays: deque[tuple[float, float]] = deque()
        self._sequence: tuple[int, int] | None = None
        self._counts: deque[tuple[int, int, int]] = deque()

    def take_clock(self, offset_ns: int, uncertainty_ns: int | None) -> None:
        """Take an estimate of the offset between the clocks of both sites."""
        self._offset_ns = offset_ns
        self.clock = None if uncertainty_ns is None else (offset_ns, uncertainty_ns)

    def take_touch(self, t_s: float, touch: Touch) -> None:
        """Take an accepted touch packet."""
        late, self._touch_s = t_s - self._touch_s > LATE_S, t_s
        if self._delays and t_s < self._delays[-1][0]:
            self._delays.clear()
            self._counts.clear()
        self._delays.append((t_s, (t_s * 1e9 - (touch.time_ns - self._offset_ns)) * 1e-6))
        while t_s - self._delays[0][0] > _DELAY_WINDOW_S:
            self._delays.popleft()
        missed = 0
        if late and self._sequence is not None and self._sequence[0] == touch.session:
            missed = max(0, touch.sequence - self._sequence[1] - 1)
        self._sequence = touch.session, touch.sequence
        second = math.floor(t_s)
        if self._counts and self._counts[-1][0] == second:
            _, came, lost = self._counts.pop()
            self._counts.append((second, came + 1, lost + missed))
        else:
            self._counts.append((second, 1, missed))
        while second - self._counts[0][0] > _LOSS_WINDOW_S:
            self._counts.popleft()

    def largest_age_s(self, after_s: float) -> float:
        """Return the largest delay of the touch packets accepted after a time, s; 0 where it is unknown."""
        if self.clock is None:
            return 0.0
        delays_ms = takewhile(lambda delay: delay[0] > after_s, reversed(self._delays))
        return max(0.0, max((delay_ms for _, delay_ms in delays_ms), default=0.0)) * 1e-3

    def shown(self, now_s: float) -> dict[str, float | None]:
        """Return delay, its standard deviation and age, ms, and the lost share of packets; None if unknown."""
        fresh = now_s - self._touch_s <= _DELAY_WINDOW_S
        delays = [delay_ms for _, delay_ms in self._delays]
        known = fresh and bool(delays) and self.clock is not None
        uncertainty_ms = 0.0 if self.clock is None else self.clock[1] * 1e-6
        mean = sum(delays) / len(delays) if known else 0.0
        spread = math.sqrt(sum((delay - mean) ** 2 for delay in delays) / len(delays)) if known else 0.0
        came, lost = (sum(row[column] for row in self._counts) for column in (1, 2))
        return {
            "delay_ms": round(mean, 2) if known else None,
            "delay_sd_ms": round(max(spread, uncertainty_ms), 2) if known else None,
            "age_ms": round((now_s - self._touch_s) * 1e3, 1) if fresh else None,
            "loss": round(lost / (came + lost), 4) if fresh and came else None,
        }


class SiteNow:
    """Newest reports of the site. Pure: time is an argument, s of the site's clock.

    Attributes:
        state: state of its session.
        both: whether both sites are engaged.
        wanted: whether it engages as soon as it can.
        fault, remote_fault: latched fault of the operator site and of the remote site, or None.
        remote_stale: since when no motion arrives at the engaged remote site; empty otherwise.
        refusal: the site's text why it refuses to connect; empty otherwise.
        figures: contents of its status file.
        calibrated: readable description of the calibration; empty if unknown.
        roughness_um: scale of the roughness in um; None if it was not calibrated.
        remote_consent: what the remote site has noted of the patient's consent; None while it is unknown.
        stop_asked_s: time of the request for the latched emergency stop; None without one.
        stop_after_s: time from that request to each device's confirmation; None before it.
        lost_engaged: whether the session ended while engaged and no other has begun.
        paused: reason of the last disengaging, empty if the operator asked for it; None if there was none.
        heard_s, answered_s, rendered_s: times of the newest message, answer of the local control, and device output.
        ready: whether each device is ready.
        was_ready: devices that have ever been ready.
        whys: why each device is not ready; empty if it is.
        coupling: coupling of the hand to the remote hand.
        hand: place of the operator's hand; None if unknown.
        patient: what the remote site last reported of its patient; None without a pain slider.
        patient_s: time of that report, s.
    """

    def __init__(self) -> None:
        self.state = LinkState.DISCONNECTED
        self.both = self.wanted = self.lost_engaged = False
        self.fault: Fault | None = None
        self.remote_fault: Fault | None = None
        self.paused: str | None = None
        self.refusal = self.remote_stale = self.calibrated = ""
        self.roughness_um: RoughnessUm | None = None
        self.remote_consent: NotedConsent | None = None
        self.session = 0
        self.gap_s: float | None = None
        self.figures: dict[str, Any] = {}
        self.link = LinkNow()
        self.bus = BusNow()
        self.stop_asked_s: float | None = None
        self.stop_after_s: dict[str, float | None] = {}
        self._known_s = -math.inf
        """Time of the newest known state of the session."""
        self.heard_s = self.answered_s = self.rendered_s = -math.inf
        self.ready: dict[str, bool] = {}
        self.was_ready: set[str] = set()
        self.whys: dict[str, str] = {}
        self.coupling: Coupling = DIRECT
        self.hand: Places | None = None
        self.patient: RemotePatient | None = None
        self.patient_s = -math.inf

    def silent_s(self, now_s: float) -> float:
        """Return the time since the newest message or answer, s; infinite before the first. Later times are ignored."""
        ages_s = [_age_s(now_s, at_s) for at_s in (self.heard_s, self.answered_s)]
        return min((age_s for age_s in ages_s if age_s >= 0.0), default=math.inf)

    @property
    def edges(self) -> list[str]:
        """Edges of the remote hand's workspace that the command is close to; empty if it is unknown."""
        return [] if self.hand is None else edges(self.coupling.command(self.hand))

    @property
    def link_silent(self) -> bool:
        """Whether touch packets fail to arrive while this site is engaged; its outputs are then neutral."""
        return self.state is LinkState.ENGAGED and self.gap_s is not None and self.gap_s > GAP_S

    @property
    def stopping(self) -> bool:
        """Whether an emergency stop of this site is latched."""
        return self.stop_asked_s is not None or (self.fault is not None and self.fault.code in STOPS)

    def word(self, now_s: float, *, live: bool, pauses: bool) -> str:
        """Return the state to show.

        Args:
            now_s: time, s of the site's clock.
            live: whether the site runs; a recording is never silent.
            pauses: whether a disengaged session counts as paused, as in an examination.
        """
        sources = []
        if live and math.isfinite(max(self.heard_s, self.answered_s)):
            sources.append(Source(self.silent_s(now_s), SILENT_S))
            if self.state is LinkState.ENGAGED:
                sources.append(Source(_age_s(now_s, self.rendered_s), SILENT_S))
        return shown_state(self._known(pauses), sources, link_silent=self.link_silent, stopping=self.stopping)

    def _known(self, pauses: bool) -> str:
        """Return the last known state."""
        if self.state is LinkState.FAULT or self.remote_fault is not None:
            return FAULT
        if self.state is LinkState.ENGAGED:
            return ENGAGED if self.both else ENGAGING
        if self.state is LinkState.DISCONNECTED:
            return DISCONNECTED
        if self.wanted:
            return ENGAGING
        return PAUSED if self.paused is not None and pauses else CONNECTED

    def take_happening(self, t_s: float, happening: Happening) -> None:
        """Take an event of the session."""
        self._known_s = max(self._known_s, t_s)
        session, text = happening.session, happening.text
        match happening.what:
            case "connected":
                self._become(self._unless_fault(LinkState.CONNECTED))
                self.session, self.lost_engaged = session, False
            case "engaged":
                self._become(LinkState.ENGAGED)
                self.paused = None
            case "disengaged":
                self._become(LinkState.CONNECTED)
                self.paused = text
            case "disconnected" | "left":
                self._become(self._unless_fault(LinkState.DISCONNECTED))
                self.session = 0
            case "fault":
                self.state, self.fault = LinkState.FAULT, happening.fault or Fault(FaultCode.UNKNOWN)
            case "cleared":
                self.state, self.fault = LinkState.CONNECTED if session else LinkState.DISCONNECTED, None
                self.stop_asked_s, self.stop_after_s = None, {}
        if REMOTE in self.ready:
            self._remote_hand()

    def take_rendered(self, t_s: float, both: bool, gap_s: float | None) -> None:
        """Take whether both sites are engaged, and the time since the last touch packet, s."""
        self.rendered_s, self.both, self.gap_s = t_s, both, gap_s

    def take_figures(self, t_s: float, figures: dict[str, Any]) -> None:
        """Take the contents of the site's status file.

        Raises:
            TypeError: the figures are no map.
        """
        if not isinstance(figures, dict):
            raise TypeError("figures are no map")
        self.figures = figures
        self.calibrated = str(figures.get("calibrated", ""))
        self.roughness_um = RoughnessUm.of(figures.get("roughness_um"))
        noted = figures.get("remote_consent")
        self.remote_consent = NotedConsent.of(noted) if isinstance(noted, dict) else None
        if isinstance(coupling := figures.get("coupling"), dict):
            self.coupling = Coupling.unpack(Coupling(**coupling).pack())  # checks the values
        self.take_brief(t_s, figures)
        for name, line in figures.get("devices", {}).items():
            self._device(device_named(name), str(line.get("missing", "")))
            self.bus.take(t_s, device_named(name), line)
        self._remote_hand()

    def take_brief(self, t_s: float, report: Mapping[str, Any]) -> None:
        """Take state, faults and confirmations of a stop, from the figures or from an answer of the local control.

        Feed and answers arrive on two connections, so a report that a newer one has overtaken is ignored. A report that
        is older by more than _OVERTAKEN_S comes from a restarted clock and is taken.
        """
        if 0.0 < self._known_s - t_s < _OVERTAKEN_S:
            return
        self._known_s = t_s
        state = str(report.get("state", self.state.name))
        self._become(LinkState.ENGAGED if state in _ENGAGED_HERE else LinkState[state.upper()])
        self.fault, self.remote_fault = read_fault(report.get("fault")), read_fault(report.get("remote_fault"))
        paused = report.get("paused", self.paused)
        self.paused = None if paused is None else str(paused)
        self.refusal = str(report.get("refusal", ""))
        self.remote_stale = str(report.get("remote_stale", ""))
        self.wanted = bool(report.get("wanted", self.wanted))
        self.session = int(report.get("session", self.session))
        asked_ns = report.get("stop_asked_ns")
        self.stop_asked_s = None if asked_ns is None else asked_ns * 1e-9
        names = [device_named(name) for name in report.get("stop_devices", ())]
        self.stop_after_s = dict(zip(names, report.get("stop_after_s", ()), strict=False))
        patient = remote_patient(report)
        if patient is not None:
            self.patient, self.patient_s = patient, int(report.get("pain_ns", 0)) * 1e-9
        elif self.session == 0:
            self.patient = None
        if REMOTE in self.ready:
            self._remote_hand()

    def _remote_hand(self) -> None:
        """Take the remote hand's readiness from the newest report: figures alone come once a second, and lag behind."""
        self._device(REMOTE, "" if self.session else texts.NO_REMOTE_SITE)

    def _device(self, name: str, why: str) -> None:
        self.ready[name], self.whys[name] = not why, why
        if not why:
            self.was_ready.add(name)

    def _become(self, state: LinkState) -> None:
        """Take the link's state; an event or an answer, whichever comes first, shows that it was lost."""
        if state is LinkState.DISCONNECTED:
            self.lost_engaged = self.lost_engaged or self.state is LinkState.ENGAGED
        elif state is not LinkState.FAULT:
            self.lost_engaged = False
        self.state = state

    def _unless_fault(self, state: LinkState) -> LinkState:
        return LinkState.FAULT if self.state is LinkState.FAULT else state
