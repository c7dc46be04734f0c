"""Makes the status of a site, the same for both: for its status file, and for answers to local commands."""

import logging
from collections import Counter
from collections.abc import Sequence
from typing import Any, Protocol

from common.faults.texts import fault_figures
from common.fingers import FINGERS
from common.link.packet_filter import PacketFilter
from common.link.session_display import ENGAGING, shown_state
from common.link.session_state import Session
from common.recording.recorder import Recorder, recording_figures
from common.runtime.containment import Containment
from common.timing.tick_age import TickAge

log = logging.getLogger(__name__)


class Stopping(Protocol):
    """Progress of an emergency stop."""

    @property
    def asked_ns(self) -> int | None:
        """Time at which the latched stop was requested, ns; None without one."""

    @property
    def after_s(self) -> dict[str, float | None]:
        """Time from the request to each device's confirmation, s; None for a device that has not confirmed."""


class SessionEnd(Protocol):
    """A site's end of the session."""

    @property
    def session(self) -> Session:
        """State and latched fault of the session."""

    @property
    def both_engaged(self) -> bool:
        """Whether outputs may act."""

    @property
    def acceptance(self) -> PacketFilter:
        """Filter of the packets on which the site acts."""

    @property
    def damaged(self) -> Counter[str]:
        """Number of unreadable packets of each stream."""

    @property
    def stopped(self) -> str:
        """Outcome of the last emergency stop."""

    @property
    def stopping(self) -> Stopping:
        """Progress of the latched emergency stop."""


class Devices(Protocol):
    """All devices of a site."""

    @property
    def tick(self) -> TickAge:
        """Age of the tick, which decides whether its commands may be sent."""

    def missing(self) -> str:
        """Return which devices are missing; empty when all are connected."""

    def figures(self) -> dict[str, object]:
        """Return the figures of each device for the status file."""


def in_brief(end: SessionEnd, missing: str) -> dict[str, Any]:
    """Return state, fault, pause, missing devices and outcome of the last emergency stop; what does not apply is empty.

    The state is `engaged` only while outputs may act. It is `engaging` until the far side has engaged, and `lost`
    while that is silent. For a latched stop there are also its time and each device's time to confirm, s.
    """
    session = end.session
    known = ENGAGING if session.engaged and not end.both_engaged else session.state.name.lower()
    return {
        "state": shown_state(known, link_silent=session.silent),
        "fault": session.fault,
        "paused": session.paused,
        "missing": missing,
        "estop": end.stopped,
        "stop_asked_ns": end.stopping.asked_ns,
        "stop_devices": list(end.stopping.after_s),
        "stop_after_s": list(end.stopping.after_s.values()),
    }


def staleness(end: SessionEnd, acts_on: str, now_ns: int, gap_s: float) -> str:
    """Return which data of an engaged site is late, and for how long; empty for fresh data or a site not engaged.

    Data on the stream `acts_on` is late after `gap_s` without an accepted packet, s; then outputs go to safe.
    """
    if not end.session.engaged:
        return ""
    gap_ns = end.acceptance.gap_ns(now_ns)
    if gap_ns is None:
        return f"no {acts_on} has come yet"
    return f"no {acts_on} for {gap_ns * 1e-9:.2f} s" if gap_ns > gap_s * 1e9 else ""


def desk_answer(verb: str, end: SessionEnd, not_ready: str) -> dict[str, Any]:
    """Return the answer to a local command that was carried out, and log the command unless it only asks.

    `not_ready` is the gate's fault or else the missing devices; empty when the site may engage.
    """
    answer = in_brief(end, not_ready)
    if verb not in ("status", "attend"):
        log.info("desk: %s, now %s", verb, answer["state"])
    return answer


def recording_stopped(recorder: Recorder | None, contain: Containment) -> str:
    """Return why a site's recording stopped; empty while it runs, and for a site without one."""
    return (recorder.failed if recorder is not None else None) or contain.latest.get("record", "")


def site_figures(
    end: SessionEnd,
    devices: Devices,
    recorder: Recorder | None,
    limited: Sequence[tuple[str, ...]],
    *,
    sent: dict[str, int],
    spared: dict[str, int],
    contain: Containment,
    acts_on: str,
    stale: str,
) -> dict[str, object]:
    """Return the figures of session, devices, limits, packets and recording for the status file.

    Args:
        end: this site's end of the session.
        devices: all devices of the site.
        recorder: recorder of the site; None for a site that does not record.
        limited: for each finger, the limits that its gate applied in the last tick; empty before the first.
        sent: number of packets sent of each latest-only stream.
        spared: number of ticks without a packet of each, because its change was imperceptible.
        contain: contained exceptions of the site; one in its step `record` also counts as a failed recording.
        acts_on: stream from which `end` accepts packets.
        stale: late data of the site, as `staleness` returns it; empty for fresh data.
    """
    acceptance = end.acceptance
    return {
        **in_brief(end, devices.missing()),
        "fault": fault_figures(end.session.fault),
        "stale": stale,
        "devices": devices.figures(),
        "limited": {FINGERS[finger]: limits for finger, limits in enumerate(limited) if limits},
        "age_ms": round(acceptance.age_ns * 1e-6, 3),
        "max_age_ms": round(acceptance.max_age_ns * 1e-6, 3),
        "sent": sent,
        "spared": spared,
        "held_back": devices.tick.held_back,
        "stood_still_s": round(devices.tick.clock.stood_still_s, 3),
        "received": {acts_on: acceptance.received},
        "superseded": {acts_on: acceptance.lost},
        "refused": {acts_on: dict(acceptance.refused), "damaged": dict(end.damaged)},
        **recording_figures(recorder),
        "recording_failed": recording_stopped(recorder, contain),
        "contained": dict(contain.places),
    }
