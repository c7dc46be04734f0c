"""The console's line to the site's desk, in a thread of its own: an emergency stop does not wait for anything else."""

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
"""Who is not answered by then is told so."""
AGAIN_S = 0.05
"""An emergency stop is asked for again so often until it is answered, however long that takes."""

Told = dict[str, Any]


class LocalControlSilent(OSError):
    """The site's desk does not answer."""


@dataclass(slots=True)
class _Asked:
    verb: str
    details: Told
    told: "Future[Told]"
    until_s: float
    again_s: float = 0.0


class LocalControlClient:
    """Asks the desk of a running site; finds it again whenever it is gone."""

    def __init__(self, port: int, keys: KeyPair):
        """Connect in the background."""
        self._port, self._keys = port, keys
        self._new: queue.SimpleQueue[_Asked | None] = queue.SimpleQueue()
        self._bell, self._ear = sockets.socketpair()
        self._bell.setblocking(False)
        self._contained = Containment()
        self._thread = threading.Thread(target=self._run, name="desk line", daemon=True)
        self._thread.start()

    def ask(self, verb: str, details: Told | None = None) -> "Future[Told]":
        """Ask for something.

        The future holds what the desk tells; or DeskSilent after PATIENCE_S, or Refused. An emergency stop goes on
        being asked for beyond that, and its future waits for the answer.
        """
        asked = _Asked(verb, details or {}, Future(), time.monotonic() + PATIENCE_S)
        self._new.put(asked)
        self._ring()
        return asked.told

    def close(self) -> None:
        """End the thread; what is still waited for is cancelled."""
        self._new.put(None)
        self._ring()
        self._thread.join(timeout=2.0)
        self._bell.close()
        self._ear.close()

    def _ring(self) -> None:
        """Wake the thread; a bell that is full rings already."""
        with suppress(BlockingIOError):
            self._bell.send(b"!")

    def _run(self) -> None:
        context = zmq.Context()
        line: zmq.Socket[bytes] = context.socket(zmq.DEALER)
        prepare_socket(line)
        # A request to nobody fails now and does not arrive minutes later; an emergency stop is asked for again.
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
                    with self._contained.step("desk's answer", latches=False):
                        _take(line, waiting)
                with self._contained.step("request to the desk", latches=False):
                    _send(line, waiting)
        finally:
            for asked in waiting.values():
                asked.told.cancel()
            context.destroy(linger=0)


def _send(line: "zmq.Socket[bytes]", waiting: dict[int, _Asked]) -> None:
    """Send what is due, and give up on what has waited too long; emergency stops first."""
    now_s = time.monotonic()
    for sequence in sorted(waiting, key=lambda number: (waiting[number].verb != "estop", number)):
        asked = waiting[sequence]
        stops = asked.verb == "estop"
        if not stops and now_s >= asked.until_s:
            del waiting[sequence]
            asked.told.set_exception(LocalControlSilent("the operator site does not answer"))
        elif now_s >= asked.again_s:
            try:
                line.send(Request(0, sequence, time.monotonic_ns(), asked.verb, asked.details).encode(), zmq.DONTWAIT)
            except zmq.Again:
                asked.again_s = now_s + AGAIN_S  # nobody is there yet
            except BadPacket as error:
                del waiting[sequence]
                asked.told.set_exception(Refused(str(error)))
            else:
                asked.again_s = now_s + AGAIN_S if stops else asked.until_s + 1.0


def _take(line: "zmq.Socket[bytes]", waiting: dict[int, _Asked]) -> None:
    """Take the answers that came; one to a request that is not waited for counts for nothing."""
    while True:
        try:
            answer = Answer.decode(line.recv(zmq.DONTWAIT))
        except zmq.Again:
            return
        except BadPacket as error:
            log.warning("desk: %s", error)
            continue
        asked = waiting.pop(answer.sequence, None)
        if asked is None or not asked.told.set_running_or_notify_cancel():
            continue
        if answer.refused:
            asked.told.set_exception(Refused(answer.refused))
        else:
            asked.told.set_result(answer.details)
