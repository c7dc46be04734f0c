"""The desk of a site: where a person at that site asks its process for something, above all for an emergency stop.

Requests and answers are those of the link's control stream, on a port of its own that is bound to loopback. Only the
owner of the site's own secret key is let in: who may read that file may run the site as well.
"""

import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Protocol

import zmq

from common.faults.texts import said_fault
from common.link.authenticator import Authenticator
from common.link.curve import (
    Inbox,
    LinkProblem,
    prepare_socket,
    receive_requests,
    send_answer,
    serve_curve,
    use_curve,
)
from common.link.keys import KeyPair
from common.link.session_state import Refused
from common.wire.packets import BadPacket
from common.wire.session_messages import LONGEST_REFUSAL, Answer, Request

HOST = "127.0.0.1"
_DOMAIN = "desk"
_PATIENCE_S = 1.0
_OUTCOME_S = 2.0
"""On the slowest link the far site's word of what came of a request takes 1.3 s."""
_ASK_AGAIN_S = 0.05
_AT_ONCE = 16
"""Requests that one tick carries out; the socket takes turns among those who ask."""

Do = Callable[[str, dict[str, Any]], dict[str, Any]]
"""Carries out a verb with its details, returns what to tell; raises Refused."""


class LocalControl(Protocol):
    """Takes requests of a person at the site: `LocalControlSocket` by a socket, a test bed's in memory."""

    def serve(self, now_ns: int, do: Do) -> None:
        """Carry out what was asked since the last call, and answer."""


class LocalControlSocket:
    """The site's side. Never blocks."""

    def __init__(self, port: int, keys: KeyPair):
        """Bind.

        Raises:
            LinkProblem: the port is in use.
        """
        self._context = zmq.Context()
        # However often something on this machine asks how it goes, a person's emergency stop gets through.
        self._authenticator = Authenticator(self._context, lambda _, key: key == keys.public, limited=False)
        self._socket = self._context.socket(zmq.ROUTER)
        prepare_socket(self._socket)
        serve_curve(self._socket, keys, _DOMAIN)
        try:
            self._socket.bind(f"tcp://{HOST}:{port}")
        except zmq.ZMQError as error:
            self.close()
            raise LinkProblem(f"{HOST}:{port} (desk): {error.strerror}; choose another desk_port") from None
        self._inbox = Inbox(self._socket)

    def serve(self, now_ns: int, do: Do) -> None:
        """Carry out what was asked since the last call, and answer."""
        for sender, packet in receive_requests(self._inbox, _AT_ONCE):
            try:
                request = Request.decode(packet)
            except BadPacket:
                continue
            refused, told = "", {}
            try:
                told = do(request.verb, request.details)
            except (Refused, BadPacket) as error:  # the latter: more than a packet to the far site can hold
                refused = str(error)[:LONGEST_REFUSAL]
            send_answer(self._socket, sender.who, Answer(0, request.sequence, now_ns, refused, told).encode())
            self._inbox.stale()

    def close(self) -> None:
        """Give the port back."""
        self._authenticator.close()
        self._context.destroy(linger=0)

    def __enter__(self) -> "LocalControlSocket":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def stop_from_desk(port: int, keys: KeyPair) -> str:
    """Ask a running site for an emergency stop; returns what its devices, and those of the far site, said of it.

    Raises:
        LinkProblem: no site answers.
    """
    ask_desk(port, keys, "estop")
    until_s = time.monotonic() + _OUTCOME_S
    while time.monotonic() < until_s:
        outcome = ask_desk(port, keys, "status")["estop"]
        if outcome:
            return str(outcome)
        time.sleep(_ASK_AGAIN_S)
    return "stopped, but not confirmed: the site says nothing of it"


def clear_from_desk(port: int, keys: KeyPair) -> None:
    """Ask a running site to clear the latched fault, at the far site too, and wait until it is cleared.

    Raises:
        LinkProblem: no site answers.
        Refused: a fault is still latched, here or at the far site; the message says which and why.
    """
    ask_desk(port, keys, "clear_fault")
    until_s = time.monotonic() + _OUTCOME_S
    while True:
        told = ask_desk(port, keys, "status")
        here, far = said_fault(told["fault"]), said_fault(told.get("remote_fault"))
        if not here and not far:
            return
        if far and (refusal := told.get("refusal")):
            raise Refused(f"the far site says: {refusal}")
        if time.monotonic() >= until_s:
            raise Refused(f"still latched: {here or f'{far} (at the far site)'}")
        time.sleep(_ASK_AGAIN_S)


def ask_desk(port: int, keys: KeyPair, verb: str, details: dict[str, Any] | None = None) -> dict[str, Any]:
    """Ask a running site on this machine for something; returns what it tells.

    Raises:
        LinkProblem: no site answers there.
        Refused: it will not, and says why.
    """
    context = zmq.Context()
    try:
        socket: zmq.Socket[bytes] = context.socket(zmq.DEALER)
        prepare_socket(socket)
        use_curve(socket, keys, keys.public)
        socket.connect(f"tcp://{HOST}:{port}")
        socket.send(Request(0, 1, time.monotonic_ns(), verb, details or {}).encode())
        if not socket.poll(round(_PATIENCE_S * 1e3)):
            raise LinkProblem(f"{HOST}:{port}: no site with this key answers; is it running?")
        answer = Answer.decode(socket.recv())
    finally:
        context.destroy(linger=0)
    if answer.refused:
        raise Refused(answer.refused)
    return answer.details
