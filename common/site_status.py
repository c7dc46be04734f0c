"""What a site tells of itself, the same for both: in its status file, and to who asks at its desk."""

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
    """How an emergency stop goes."""

    @property
    def asked_ns(self) -> int | None:
        """When the one that is latched was asked for; None where none is."""

    @property
    def after_s(self) -> dict[str, float | None]:
        """How long after that each device confirmed, s; None while one has not."""


class SessionEnd(Protocol):
    """A site's end of the session."""

    @property
    def session(self) -> Session:
        """Its state and latched fault."""

    @property
    def both_engaged(self) -> bool:
        """Whether outputs may act."""

    @property
    def acceptance(self) -> PacketFilter:
        """Of the packets that the site acts on."""

    @property
    def damaged(self) -> Counter[str]:
        """Packets of each stream that could not be read."""

    @property
    def stopped(self) -> str:
        """What came of the last emergency stop."""

    @property
    def stopping(self) -> Stopping:
        """Of the emergency stop that is latched."""


class Devices(Protocol):
    """All devices of a site."""

    @property
    def tick(self) -> TickAge:
        """Which of its commands were too old to be sent."""

    def missing(self) -> str:
        """What keeps the site from working; empty when all devices are there."""

    def figures(self) -> dict[str, object]:
        """What the status file tells of each device."""


def in_brief(end: SessionEnd, missing: str) -> dict[str, Any]:
    """State, fault, pause, what is missing, and what came of the last emergency stop, each empty where there is none.

    The state is `engaged` only while outputs may act: `engaging` before the far side is, `lost` while it is silent.
    While a stop is latched also when it was asked for, and after how many seconds each device confirmed.
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
    """What a site that acts has waited for too long; empty while that is fresh, and while the site does not act.

    Args:
        end: this site's end of the session.
        acts_on: the stream that `end` accepts packets of.
        now_ns: this site's clock.
        gap_s: without an accepted packet for longer, outputs go to safe.
    """
    if not end.both_engaged:
        return ""
    gap_ns = end.acceptance.gap_ns(now_ns)
    if gap_ns is None:
        return f"no {acts_on} has come yet"
    return f"no {acts_on} for {gap_ns * 1e-9:.2f} s" if gap_ns > gap_s * 1e9 else ""


def desk_answer(verb: str, end: SessionEnd, not_ready: str) -> dict[str, Any]:
    """What a person is told at the desk once a request was carried out; all but questions are logged.

    Args:
        verb: what was asked for.
        end: this site's end of the session.
        not_ready: a gate's fault, or else what is missing; empty when the site may engage.
    """
    told = in_brief(end, not_ready)
    if verb not in ("status", "attend"):
        log.info("desk: %s, now %s", verb, told["state"])
    return told


def recording_stopped(recorder: Recorder | None, contain: Containment) -> str:
    """Why a site's recording stopped; empty while it has not, and where there is none."""
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
    """What the status file tells of session, devices, limits, packets and recording.

    Args:
        end: this site's end of the session.
        devices: all devices of the site.
        recorder: None when the site does not record.
        limited: for each finger, the limits that its gate applied in the last tick; empty before the first.
        sent: packets of each latest-only stream that went out.
        spared: ticks of each that were not worth a packet.
        contain: what the site has contained; an exception in its step `record` is a failed recording, too.
        acts_on: the stream that `end` accepts packets of.
        stale: what the site has waited for too long; empty where all is fresh.
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
