"""Finds the present causes of alarms in the state of site, fingers and console."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from common.fingers import FINGERS
from common.limits import PLATE_FAULT_C, PLATE_PROFILES
from common.wire.packets import LinkState
from operator_site.console import texts
from operator_site.console.alarms.alarms import Cause
from operator_site.console.camera.camera_now import CameraNow, Seen
from operator_site.console.state.fingers_now import FingersNow
from operator_site.console.state.frame import Priority
from operator_site.console.state.site_now import SILENT_S, SiteNow
from operator_site.console.voice.voice_now import VoiceNow
from operator_site.safety.limit_flags import Limit
from operator_site.session.emergency_stop import REMOTE

FAULT, REMOTE_FAULT = "fault", "remote fault"
"""Identifiers of the alarms of a site's fault."""
STOP_PATIENCE_S = 0.3
"""Time for a device to confirm an emergency stop, s; the remote hand has a round trip more."""
LINK_SLOW_MS = 100.0
"""Smallest delay of a slow link, ms; from here a hand notices it and must move slowly."""
DISK_NEARLY_FULL = 0.90
"""Smallest used share of a disk that is nearly full."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """State of the console's process and of its user.

    Attributes:
        disk_used: used share of the disk, 0..1.
        recording_failed: whether the console's own record has failed.
        sound: the user's answer to the test sound, `heard` or `refused`; empty before it.
        page_slow: whether the page in control skips pictures.
        resumed: whether the examination was begun in an earlier run of the console.
        camera: what the camera shows; None without a camera.
        voice: what is heard at both ends; None without a voice.
    """

    disk_used: float = 0.0
    recording_failed: bool = False
    sound: str = ""
    page_slow: bool = False
    resumed: bool = False
    camera: CameraNow | None = None
    voice: VoiceNow | None = None


def causes(
    now_s: float, site: SiteNow, fingers: FingersNow, used: Sequence[bool], around: Surroundings, *, live: bool = True
) -> dict[str, Cause]:
    """Return all present causes by their identifiers.

    Args:
        now_s: time, s of the operator site's clock.
        site: state of the site.
        fingers: state of the fingers.
        used: whether each finger is in use.
        around: state of the console's process.
        live: whether the site runs; a recording is never silent and has no slow page.
    """
    found: dict[str, Cause] = {}
    old_s = now_s - site.heard_s
    if live and old_s > SILENT_S and math.isfinite(old_s):
        # No latch: if the silence ends the session, its cause stays on the page as the reason of the pause.
        urgent = site.wanted or site.state in (LinkState.ENGAGED, LinkState.FAULT)
        found["feed"] = Cause(Priority.HIGH if urgent else Priority.LOW, texts.no_data(old_s))
        if causes_unknown(now_s, site, live=live):
            return found  # all other causes would rest on old data
    if (waiting := unconfirmed(now_s, site)) and site.stop_asked_s is not None:
        found["stop"] = Cause(
            Priority.HIGH, texts.not_confirmed(waiting), texts.STOP_LATE, silenceable=False, latches=True
        )
    if site.lost_engaged or site.link_silent:
        found["link"] = Cause(Priority.HIGH, texts.LINK_LOST, texts.LINK_BACK, latches=site.lost_engaged)
    elif site.remote_stale:
        found["motion"] = Cause(Priority.HIGH, texts.MOTION_LOST)
    found |= _plates(now_s, site, fingers, used)
    if site.fault and not site.stopping and not any(cause.priority is Priority.HIGH for cause in found.values()):
        found[FAULT] = Cause(Priority.HIGH, texts.fault(site.fault), texts.FAULT_OVER, latches=True)
    elif site.remote_fault and not site.stopping and not site.fault:
        text = texts.remote_fault(site.remote_fault)
        found[REMOTE_FAULT] = Cause(Priority.HIGH, text, texts.FAULT_OVER, latches=True)
    for name, ready in site.ready.items():
        if not ready and name in site.was_ready and "link" not in found and site.state is not LinkState.DISCONNECTED:
            found[f"device {name}"] = Cause(Priority.MEDIUM, texts.device_lost(name))
    link = site.link.shown(now_s)
    delay_ms, sd_ms = link["delay_ms"], link["delay_sd_ms"]
    if delay_ms is not None and sd_ms is not None and delay_ms > LINK_SLOW_MS and "link" not in found:
        found["slow link"] = Cause(Priority.MEDIUM, texts.link_slow(delay_ms, sd_ms))
    if site.figures.get("behind"):
        found["behind"] = Cause(
            Priority.LOW, texts.site_slow(site.figures.get("rate_hz"), site.figures.get("wanted_hz"))
        )
    for name, what in site.bus.trouble(now_s).items():
        found[f"bus {name}"] = Cause(Priority.LOW, texts.bus_trouble(name, what))
    return found | _recording(site, around) | _lesser(around, live)


def causes_unknown(now_s: float, site: SiteNow, *, live: bool = True) -> bool:
    """Return whether the site is silent, so that all other causes are unknown."""
    return live and math.isfinite(site.heard_s) and site.silent_s(now_s) > SILENT_S


def unconfirmed(now_s: float, site: SiteNow) -> list[str]:
    """Return the devices that are late to confirm the emergency stop."""
    if site.stop_asked_s is None:
        return []
    waited_s = now_s - site.stop_asked_s
    round_trip_s = 2e-3 * (site.link.shown(now_s)["delay_ms"] or 0.0)
    return [
        name
        for name, after_s in site.stop_after_s.items()
        if after_s is None and waited_s > STOP_PATIENCE_S + (round_trip_s if name == REMOTE else 0.0)
    ]


def _plates(now_s: float, site: SiteNow, fingers: FingersNow, used: Sequence[bool]) -> dict[str, Cause]:
    found = {}
    for finger, plate_c in enumerate(fingers.plates_c(now_s)):
        name = FINGERS[finger]
        if not used[finger]:
            continue
        if plate_c > PLATE_FAULT_C:
            after = texts.PLATE_BACK.format(finger=texts.capital(name))
            found[f"plate {name}"] = Cause(Priority.HIGH, texts.plate_over(name, plate_c), after, latches=True)
        elif site.both and fingers.holds(finger, Limit.PLATE_TEMPERATURE) and plate_c > PLATE_PROFILES["comfort"].low_c:
            found[f"plate {name}"] = Cause(Priority.MEDIUM, texts.plate_held(name, plate_c))
    return found


def _recording(site: SiteNow, around: Surroundings) -> dict[str, Cause]:
    found = {}
    if site.figures.get("disk_full") or (around.recording_failed and around.disk_used >= DISK_NEARLY_FULL):
        found["recording"] = Cause(Priority.MEDIUM, texts.DISK_FULL)
    elif site.figures.get("recording_failed"):
        found["recording"] = Cause(Priority.MEDIUM, texts.NOT_RECORDED)
    elif around.recording_failed:
        found["recording"] = Cause(Priority.MEDIUM, texts.CONSOLE_NOT_RECORDED)
    if site.figures.get("remote_recording"):
        found["remote recording"] = Cause(Priority.MEDIUM, texts.REMOTE_NOT_RECORDED)
    return found


def _lesser(around: Surroundings, live: bool) -> dict[str, Cause]:
    """Return the causes in the console's process, of low priority but for a required picture."""
    if not live:
        return {}
    found = {}
    if around.disk_used >= DISK_NEARLY_FULL:
        found["disk"] = Cause(Priority.LOW, texts.DISK_FILLS.format(percent=around.disk_used * 100))
    if around.sound == "refused":
        found["sound"] = Cause(Priority.LOW, texts.SOUND_OFF)
    if around.resumed:
        found["resumed"] = Cause(Priority.LOW, texts.RESTARTED)
    if around.camera is not None and around.camera.seen is not Seen.LIVE:
        priority = Priority.MEDIUM if around.camera.required else Priority.LOW
        text = texts.camera(around.camera.seen, around.camera.age_s, pauses=around.camera.required)
        found["camera"] = Cause(priority, text)
    if around.page_slow:
        found["slow"] = Cause(Priority.LOW, texts.CONSOLE_SLOW)
    return found
