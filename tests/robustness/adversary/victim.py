"""The attacked process: both ends of a session, local control and a console's feed.

    python -m tests.robustness.adversary.victim REMOTE_KEYS OPERATOR_KEYS BASE_PORT DESK_PORT FEED_PORT

It ends itself when its standard input is closed, and an abort of a library ends it as well.
"""

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread
from typing import Any

from common.faults.texts import fault_text
from common.link.keys import load_keys
from common.link.local_control import LocalControlSocket
from common.runtime.periodic_loop import PeriodicLoop
from common.wire.packets import LinkState
from operator_site.session.console_feed import ConsoleFeedSocket
from tests.robustness.hardening.own_memory import own_resident_bytes
from tests.robustness.hardening.served import Served

_TICK_S = 0.002
_FEED_BYTES = bytes(1500)


@dataclass(frozen=True)
class _Keys:
    remote: Path
    operator: Path


class Victim:
    """One session; `turn` is a tick of both sites."""

    def __init__(self, keys: _Keys, base_port: int, desk_port: int, feed_port: int) -> None:
        self._served = Served(keys, base_port)
        self._desk = LocalControlSocket(desk_port, load_keys(keys.operator))
        self._feed = ConsoleFeedSocket(feed_port, load_keys(keys.operator))
        self._moved_m = 0.0
        self._stop_ns = self._stopped_ns = 0
        self._faults = set[str]()
        self._pause_s = 0.0

    def turn(self) -> None:
        """A tick of both sites, of the desk and of the feed."""
        now_ns = time.monotonic_ns()
        self._desk.serve(now_ns, self._do)
        if self._pause_s:
            pause_s, self._pause_s = self._pause_s, 0.0
            time.sleep(pause_s)  # the library's threads read on
        self._served.turn()
        self._feed.write("operator/touch", now_ns, _FEED_BYTES)
        self._feed.step(now_ns)
        server = self._served.server
        if server.motion is not None:
            self._moved_m = max(self._moved_m, *(abs(place_m) for row in server.motion.rows for place_m in row))
        if server.session.state is LinkState.FAULT:
            self._faults.add(fault_text(server.session.fault))
            if self._stop_ns and server.stopping.asked_ns is not None:
                self._stopped_ns = self._stopped_ns or time.monotonic_ns()

    def _do(self, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        client, now_ns = self._served.client, time.monotonic_ns()
        if verb == "estop":
            self._stop_ns, self._stopped_ns = details.get("asked_ns", now_ns), 0
            client.stop(now_ns)
        elif verb == "clear_fault" and (client.remote_fault or client.session.state is LinkState.FAULT):
            client.clear(now_ns)
        elif verb == "engage":
            client.want_engaged = True
        elif verb == "annotate":
            self._pause_s = float(details["pause_s"])
        return {
            "engaged": self._served.engaged,
            "stop_s": (self._stopped_ns - self._stop_ns) * 1e-9 if self._stopped_ns else None,
            "moved_m": self._moved_m,
            "faults": sorted(self._faults),
            "own_mib": own_resident_bytes() / 2**20,
            "expelled": self._served.server.expelled.total(),
        }


def main(remote: str, operator: str, *ports: str) -> None:
    """Serve until standard input is closed."""
    base_port, desk_port, feed_port = map(int, ports)
    victim = Victim(_Keys(Path(remote), Path(operator)), base_port, desk_port, feed_port)
    ended = Event()
    Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    loop = PeriodicLoop(_TICK_S)
    while not ended.is_set():
        loop.wait()
        victim.turn()


if __name__ == "__main__":
    main(*sys.argv[1:])
