"""Both ends of a session in one loop, over real sockets."""

import subprocess
import time
from pathlib import Path
from typing import Protocol

import numpy as np

from common.link.capabilities import capabilities
from common.link.keys import TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.runtime.periodic_loop import PeriodicLoop
from common.wire.messages import TOUCH_BLOCK, TOUCH_FIELDS, Touch
from operator_site.session.session_client import SessionClient
from remote_site.session.session_server import SessionServer

TOUCH_NOTHING = TOUCH_BLOCK.to_bytes(np.zeros((5, len(TOUCH_FIELDS)), np.float32))
AT_REST = (0.0, 0.0, (0.0,) * 5)


class Keys(Protocol):
    """Key folders of both sites."""

    @property
    def remote(self) -> Path: ...
    @property
    def operator(self) -> Path: ...


class Served:
    """Both ends of a session in one loop at 500 Hz."""

    def __init__(self, keys: Keys, base_port: int) -> None:
        remote = load_keys(keys.remote)
        self.remote_link = RemoteLink("127.0.0.1", base_port, remote, TrustedKeys(keys.remote))
        self.operator_link = OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), remote.public)
        able = capabilities(("index",), 500.0)
        self.server = SessionServer(self.remote_link, able, 0.15)
        self.client = SessionClient(self.operator_link, able, 0.15, want_engaged=True)
        self.server_key = remote.public
        self.longest_gap_ns = 0
        self._sequence = 0

    def turn(self) -> None:
        now_ns = time.monotonic_ns()
        self.server.step(now_ns, "")
        session = self.server.session
        if session.ident:
            self._sequence += 1
            touch = Touch(session.ident, self._sequence, now_ns, session.state, TOUCH_NOTHING, ("",) * 5, ())
            self.remote_link.send_latest("touch", touch.encode())
        now_ns = time.monotonic_ns()  # one time a tick of the operator's site, for what it takes and what it sends
        self.client.step(now_ns, "")
        self.client.send_motion(now_ns, *AT_REST)
        self.longest_gap_ns = max(self.longest_gap_ns, self.client.acceptance.gap_ns(now_ns) or 0)

    def run(self, until: "subprocess.Popen[bytes] | None", seconds: float) -> PeriodicLoop:
        """Turn until a process has ended, or for some time."""
        loop, end_s = PeriodicLoop(0.002), time.monotonic() + seconds
        while (until.poll() is None) if until is not None else time.monotonic() < end_s:
            loop.wait()
            self.turn()
        return loop

    def works_on(self) -> None:
        """Engaged, with another hundred motion packets accepted; a stall of the machine may come between."""
        enough, end_s = self.server.acceptance.received + 100, time.monotonic() + 10.0
        while not (self.engaged and self.server.acceptance.received > enough):
            assert time.monotonic() < end_s, self.server.acceptance
            self.run(None, 0.05)

    @property
    def engaged(self) -> bool:
        return self.server.both_engaged and self.client.both_engaged
