"""Looking on: what the remote site identifies, as JSON lines for a second opinion. Asks and drives nothing."""

import json
import logging
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from common.capabilities import OBSERVER, capabilities
from common.config import ObserverConfig
from common.curve_sockets import LinkProblem
from common.fingers import FINGERS
from common.keys import Role, load_keys
from common.link import OperatorLink
from common.loop import PeriodicLoop
from common.messages import TOUCH_COLUMN, ExplorationMode, ThermalStatus, Touch
from operator_site.remote_key import remote_public_key
from operator_site.session_client import SessionClient

log = logging.getLogger(__name__)

RATE_HZ = 50.0
UNKNOWN: dict[str, Any] = {"state": "disconnected", "fingers": {}}
"""The opinion without a session: the last one no longer holds."""
_MODE, _CONTACT, _STATUS = (TOUCH_COLUMN[name] for name in ("mode", "contact", "thermal_status"))
_FORCE, _OBJECT_C, _PROBABILITY = (TOUCH_COLUMN[name] for name in ("contact_force_n", "object_c", "probability"))

_SAY = partial(print, flush=True)
"""Whoever reads along reads each line at once."""


def opinion(touch: Touch) -> dict[str, Any]:
    """What a touch packet says of each finger, in words; numbers that change all the time are not in it."""
    fingers = {}
    for name, row, material in zip(FINGERS, touch.block.tolist(), touch.materials, strict=True):
        status = ThermalStatus(int(row[_STATUS]))
        fingers[name] = {
            "mode": ExplorationMode(int(row[_MODE])).name.lower(),
            "contact": bool(row[_CONTACT]),
            "status": status.name.lower(),
            "material": material if status is ThermalStatus.IDENTIFIED else None,
        }
    return {"state": touch.state.name.lower(), "fingers": fingers}


def measured(touch: Touch) -> dict[str, Any]:
    """The numbers of each finger in contact at the moment of a packet."""
    return {
        name: {
            "force_n": round(row[_FORCE], 2),
            "object_c": round(row[_OBJECT_C], 1),
            "probability": round(row[_PROBABILITY], 3),
        }
        for name, row in zip(FINGERS, touch.block.tolist(), strict=True)
        if row[_CONTACT]
    }


def run_observer(config: ObserverConfig, stop: Callable[[], bool], tell: Callable[[str], object] = _SAY) -> None:
    """Tell a JSON line whenever what is identified changes, or nothing is known any more, until `stop()`.

    Raises:
        ValueError, OSError: keys cannot be used, or the remote site refuses this one.
    """
    keys = load_keys(config.link.keys)
    remote_key = remote_public_key(config.link)
    loop = PeriodicLoop(1.0 / RATE_HZ)
    last = UNKNOWN
    with OperatorLink(config.link.host, config.link.base_port, keys, remote_key, Role.OBSERVER) as link:
        client = SessionClient(
            link, capabilities((), RATE_HZ), config.link.max_age_s, want_engaged=False, role=OBSERVER
        )
        while not stop():
            loop.wait()
            client.step(time.monotonic_ns(), "")
            if link.key_refused():
                raise LinkProblem(
                    f"{config.link.host}:{config.link.base_port}: the remote site does not trust this key"
                )
            touch = client.touch if client.session.ident else None
            now = opinion(touch) if touch is not None else UNKNOWN
            if now == last:
                continue
            last = now
            if touch is None:
                tell(json.dumps({"time_s": None, "age_ms": None, **now, "measured": {}}))
            else:
                line = {"time_s": touch.time_ns * 1e-9, "age_ms": client.acceptance.age_ns * 1e-6, **now}
                tell(json.dumps({**line, "measured": measured(touch)}))
