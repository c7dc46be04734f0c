"""Prints what the remote site identifies as JSON lines for a second opinion; requests and drives nothing."""

import json
import logging
import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from common.config.link_models import ObserverConfig
from common.fingers import FINGERS
from common.link.capabilities import OBSERVER, capabilities
from common.link.keys import Role, load_keys
from common.link.link import OperatorLink
from common.link.session_display import DISCONNECTED, SILENT, Source, shown_state
from common.runtime.periodic_loop import PeriodicLoop
from common.wire.messages import ExplorationMode, ThermalStatus, Touch
from operator_site.session.admission import Admission
from operator_site.session.remote_key import remote_public_key
from operator_site.session.session_client import SessionClient

log = logging.getLogger(__name__)

RATE_HZ = 50.0
"""Rate of the client's loop, Hz."""
SILENT_S = 0.5
"""Maximum age of a touch that counts as an opinion, s."""

_PRINT = partial(print, flush=True)
"""Prints without buffering, so that a reader gets each line at once."""


def opinion(touch: Touch) -> dict[str, Any]:
    """Return the state of each finger in a touch packet in words, without the continuously changing numbers."""
    fingers = {}
    for name, row, material in zip(FINGERS, touch.rows, touch.materials, strict=True):
        status = ThermalStatus(int(row.thermal_status))
        fingers[name] = {
            "mode": ExplorationMode(int(row.mode)).name.lower(),
            "contact": bool(row.contact),
            "status": status.name.lower(),
            "material": material if status is ThermalStatus.IDENTIFIED else None,
        }
    return {"state": touch.state.name.lower(), "fingers": fingers}


def measured(touch: Touch) -> dict[str, Any]:
    """Return the numbers of each finger in contact in a touch packet."""
    return {
        name: {
            "force_n": round(row.contact_force_n, 2),
            "object_c": round(row.object_c, 1),
            "object_c_sd": round(row.object_c_sd, 1),
            "probability": round(row.probability, 3),
        }
        for name, row in zip(FINGERS, touch.rows, strict=True)
        if row.contact
    }


def known(client: SessionClient, now_ns: int) -> tuple[Touch | None, dict[str, Any]]:
    """Return the newest touch and its opinion; without a session or a recent touch, None and no fingers."""
    touch = client.touch
    if not client.session.ident or touch is None:
        return None, {"state": DISCONNECTED, "fingers": {}}
    gap_ns = client.acceptance.gap_ns(now_ns)
    age_s = math.inf if gap_ns is None else gap_ns * 1e-9
    said = opinion(touch)
    if shown_state(said["state"], (Source(age_s, SILENT_S),)) == SILENT:
        return None, {"state": SILENT, "fingers": {}}
    return touch, said


def run_observer(config: ObserverConfig, stop: Callable[[], bool], write: Callable[[str], object] = _PRINT) -> None:
    """Write a JSON line whenever the opinion changes or is lost, until `stop()`.

    Raises:
        ValueError, OSError: keys cannot be used.
    """
    keys = load_keys(config.link.keys)
    remote_key = remote_public_key(config.link)
    loop = PeriodicLoop(1.0 / RATE_HZ)
    last = None
    with OperatorLink(config.link.host, config.link.base_port, keys, remote_key, Role.OBSERVER) as link:
        client = SessionClient(
            link, capabilities((), RATE_HZ), config.link.max_age_s, want_engaged=False, role=OBSERVER
        )
        admission = Admission(client, link, f"{config.link.host}:{config.link.base_port}", Role.OBSERVER)
        while not stop():
            loop.wait()
            client.step(time.monotonic_ns(), "")
            if loop.ticks % round(RATE_HZ) == 0:
                admission.each_second()
            touch, now = known(client, time.monotonic_ns())
            if now == last or (last is None and touch is None):
                continue
            last = now
            if touch is None:
                write(json.dumps({"time_s": None, "age_ms": None, **now, "measured": {}}))
            else:
                line = {"time_s": touch.time_ns * 1e-9, "age_ms": client.acceptance.age_ns * 1e-6, **now}
                write(json.dumps({**line, "measured": measured(touch)}))
