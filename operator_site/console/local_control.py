"""Sends the console's requests to the operator site from a separate thread, so that an emergency stop never waits."""

import logging
import queue
import socket as sockets
import threading
import time
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import zmq

from common.link.curve import prepare_socket, use_curve
from common.link.keys import KeyPair
from common.link.local_control import HOST
from common.link.session_state import Refused
from common.runtime.containment import Containment
from common.wire.packets import BadPacket
from common.wire.session_messages import Answer, Request

log = logging.getLogger(__name__)

PATIENCE_S = 0.3
"""Longest wait for the answer to a request other than an emergency stop, s; later the request fails."""
AGAIN_S = 0.05
"""Interval at which an emergency stop is requested again until it is answered, s."""

Details = dict[str, Any]
"""Details of a request or of its answer, by name."""


class LocalControlSilent(OSError):
    """The operator site does not answer."""


@dataclass(slots=True)
class _Asked:
    verb: str
    details: Details
    answer: "Future[Details]"
    until_s: float
    again_s: float = 0.0


class LocalControlClient:
    """Sends requests to the local control of a running site and reconnects after each interruption."""

    def __init__(self, port: int, keys: KeyPair):
        """Connect in the background."""
        self._port, self._keys = port, keys
        self._new: queue.SimpleQueue[_Asked | None] = queue.SimpleQueue()
        self._bell, self._ear = sockets.socketpair()
        self._bell.setblocking(False)
        self._contained = Containment()
        self._thread = threading.Thread(target=self._run, name="local control", daemon=True)
        self._thread.start()

    def ask(self, verb: str, details: Details | None = None) -> "Future[Details]":
        """Send a request to the site.

        The future holds the details of the answer, or raises Refused, or LocalControlSilent after PATIENCE_S. An
        emergency stop is requested until it is answered, and its future waits for that answer.
        """
        asked = _Asked(verb, details or {}, Future(), time.monotonic() + PATIENCE_S)
        self._new.put(asked)
        self._ring()
        return asked.answer

    def close(self) -> None:
        """End the thread and cancel all pending requests."""
        self._new.put(None)
        self._ring()
        self._thread.join(timeout=2.0)
        self._bell.close()
        self._ear.close()

    def _ring(self) -> None:
        """Wake the thread; a full socket buffer wakes it already."""
        with suppress(BlockingIOError):
            self._bell.send(b"!")

    def _run(self) -> None:
        context = zmq.Context()
        line: zmq.Socket[bytes] = context.socket(zmq.DEALER)
        prepare_socket(line)
        # A request without a peer fails at once instead of arriving minutes later; an emergency stop is repeated.
        line.setsockopt(zmq.IMMEDIATE, 1)
        use_curve(line, self._keys, self._keys.public)
        line.connect(f"tcp://{HOST}:{self._port}")
        poller = zmq.Poller()
        poller.register(line, zmq.POLLIN)
        poller.register(self._ear, zmq.POLLIN)
        waiting: dict[int, _Asked] = {}
        sequence = 0
        try:
            while True:
                ready = dict(poller.poll(round(AGAIN_S * 1e3) if waiting else 1000))
                if self._ear.fileno() in ready:
                    self._ear.recv(4096)
                while not self._new.empty():
                    asked = self._new.get()
                    if asked is None:
                        return
                    sequence += 1
                    waiting[sequence] = asked
                if line in ready:
                    with self._contained.step("answer of the site", latches=False):
                        _take(line, waiting)
                with self._contained.step("request to the site", latches=False):
                    _send(line, waiting)
        finally:
            for asked in waiting.values():
                asked.answer.cancel()
            context.destroy(linger=0)


def _send(line: "zmq.Socket[bytes]", waiting: dict[int, _Asked]) -> None:
    """Send the due requests, emergency stops first; fail those that have waited longer than PATIENCE_S."""
    now_s = time.monotonic()
    for sequence in sorted(waiting, key=lambda number: (waiting[number].verb != "estop", number)):
        asked = waiting[sequence]
        stops = asked.verb == "estop"
        if not stops and now_s >= asked.until_s:
            del waiting[sequence]
            asked.answer.set_exception(LocalControlSilent("the operator site does not answer"))
        elif now_s >= asked.again_s:
            try:
                line.send(Request(0, sequence, time.monotonic_ns(), asked.verb, asked.details).encode(), zmq.DONTWAIT)
            except zmq.Again:
                asked.again_s = now_s + AGAIN_S  # no peer is connected yet
            except BadPacket as error:
                del waiting[sequence]
                asked.answer.set_exception(Refused(str(error)))
            else:
                asked.again_s = now_s + AGAIN_S if stops else asked.until_s + 1.0


def _take(line: "zmq.Socket[bytes]", waiting: dict[int, _Asked]) -> None:
    """Take the received answers; an answer without a pending request is ignored."""
    while True:
        try:
            answer = Answer.decode(line.recv(zmq.DONTWAIT))
        except zmq.Again:
            return
        except BadPacket as error:
            log.warning("local control: %s", error)
            continue
        asked = waiting.pop(answer.sequence, None)
        if asked is None or not asked.answer.set_running_or_notify_cancel():
            continue
        if answer.refused:
            asked.answer.set_exception(Refused(answer.refused))
        else:
            asked.answer.set_result(answer.details)
