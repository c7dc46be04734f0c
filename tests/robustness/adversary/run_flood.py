"""A process that attacks a running session with one key: it floods ports, or opens readers that never read.

    python -m tests.robustness.adversary.run_flood ROLE SIZE SECONDS KEYS REMOTE_KEY OPERATOR_KEY TARGET=PORT...

It prints how many packets it sent to each target, as JSON.
"""

import json
import os
import sys
import time
from collections import Counter
from contextlib import suppress
from itertools import count
from pathlib import Path
from random import Random

import zmq

from common.link.curve import prepare_socket, use_curve
from common.link.keys import load_keys
from common.wire.messages import Touch, motion_packet, pack_hand
from common.wire.packets import MAX_PACKET, BadPacket, LinkState
from common.wire.session_messages import Heartbeat, Request
from tests.robustness.adversary.parties import COPY

AWAY_M = -0.15
"""Where an attacker wants the remote fingers to go, in x, m."""
HOUR_NS = 3_600_000_000_000
_KINDS = {"motion": zmq.PUSH, "touch": zmq.SUB, "observed": zmq.SUB, "feed": zmq.SUB}
_VERBS = ("engage", "annotate", "disengage", "clear_fault", "goodbye", "status", "hello", "estop")
_AT_SITE = ("desk", "feed")
"""Targets at the operator's site; they have that site's key."""
_PAUSE_S = 0.0005


def forged(target: str, role: str, ident: int, number: int, size: int) -> bytes:
    """A packet that asks for what its sender may not; of `size` bytes where that is not 0."""
    now_ns = time.monotonic_ns()
    if target == "motion" and not size:
        return motion_packet(ident, 10_000 + number, now_ns, LinkState.ENGAGED, pack_hand(AWAY_M, 0.0, [0.0] * 5))
    if target == "heartbeat" and not size:
        return Heartbeat(ident, number, now_ns, LinkState.ENGAGED, now_ns, 0, HOUR_NS, 1).encode()
    if target in ("control", "desk"):
        # A copy of the operator's key may stop the session, so the copy makes only the other requests.
        verbs = _VERBS[:-1] if role == COPY else _VERBS
        verb = "status" if target == "desk" else verbs[number % len(verbs)]
        return Request(ident, number, now_ns, verb, {"text": "x" * max(0, size - 64)}).encode()
    # A reader's packet is a subscription.
    return (b"\x01" if target in ("touch", "observed", "feed") else b"") + Random(number).randbytes(max(8, size - 1))


class Attack:
    """Sockets of one key at some targets."""

    def __init__(self, keys: Path, remote_key: str, operator_key: str, ports: dict[str, int], *, reads: bool) -> None:
        self._context = zmq.Context()
        self._sockets = {}
        for target, port in ports.items():
            kind = _KINDS.get(target, zmq.DEALER)
            socket = self._context.socket(zmq.XSUB if kind == zmq.SUB and not reads else kind)
            prepare_socket(socket)
            use_curve(socket, load_keys(keys), operator_key if target in _AT_SITE else remote_key)
            if kind == zmq.SUB and reads:
                socket.subscribe(b"")
            socket.connect(f"tcp://127.0.0.1:{port}")
            self._sockets[target] = socket

    def flood(self, role: str, size: int, seconds: float) -> Counter[str]:
        """Send as fast as the sockets take it; packets sent to each target."""
        ident, sent, end_s = self._session(), Counter[str](), time.monotonic() + seconds
        for number in count(1):
            if time.monotonic() > end_s:
                break
            taken = 0
            for target, socket in self._sockets.items():
                try:
                    socket.send(forged(target, role, ident, number, size), zmq.DONTWAIT)
                except zmq.Again:
                    continue
                sent[target] += 1
                taken += 1
            if not taken:
                time.sleep(_PAUSE_S)
        return sent

    def pause(self, seconds: float) -> Counter[str]:
        """Ask now and then, and read nothing until the end; packets that waited at each target."""
        waited, end_s = Counter[str](), time.monotonic() + seconds
        for number in count(1):
            if time.monotonic() > end_s:
                break
            for target in ("heartbeat", "control"):
                if target in self._sockets and number % 5 == 0:
                    with suppress(zmq.Again):
                        self._sockets[target].send(Request(0, number, 1, "status", {}).encode(), zmq.DONTWAIT)
            time.sleep(0.01)
        for target, socket in self._sockets.items():
            while socket.type != zmq.PUSH and socket.poll(50) and waited[target] < 1000:
                socket.recv()
                waited[target] += 1
        return waited

    def _session(self) -> int:
        """Number of the session, as `touch` or `observed` sends it to a trusted reader; 0 where none does."""
        for target in ("touch", "observed"):
            if (socket := self._sockets.get(target)) is None:
                continue
            socket.send(b"\x01")
            if socket.poll(1000):
                try:
                    return Touch.decode(socket.recv()).session
                except BadPacket:
                    continue
        return 0


def main(role: str, size: str, seconds: str, keys: str, remote_key: str, operator_key: str, *targets: str) -> None:
    """Attack, say what was sent, and end."""
    os.nice(10)  # attackers are on other machines: they take no processor time from the sites
    ports = {name: int(port) for name, port in (target.split("=") for target in targets)}
    attack = Attack(Path(keys), remote_key, operator_key, ports, reads=int(size) < 0)
    seconds_s = float(seconds)
    sent = attack.pause(seconds_s) if int(size) < 0 else attack.flood(role, min(int(size), MAX_PACKET), seconds_s)
    print(json.dumps({"role": role, "size": int(size), "sent": sent}), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
