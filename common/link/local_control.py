"""Local control of a site: requests of a person at that site to its process, above all for an emergency stop.

Requests and answers have the form of the link's control stream, on a separate port that is bound to loopback. Only the
owner of the site's secret key is admitted, because that user may also run the site.
"""

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol, Self

import zmq

from common.faults.texts import said_fault
from common.link.authenticator import Authenticator
from common.link.curve import Inbox, LinkProblem, prepare_socket, receive_requests, send_answer, serve_curve, use_curve
from common.link.keys import KeyPair
from common.link.session_state import Refused
from common.wire.packets import BadPacket
from common.wire.session_messages import LONGEST_REFUSAL, Answer, Request

HOST = "127.0.0.1"
_PATIENCE_S = 1.0
"""Maximum wait for an answer, s."""
_OUTCOME_S = 2.0
"""Maximum wait for the outcome of a request, s; on the slowest link the far site's report takes 1.3 s."""
_ASK_AGAIN_S = 0.05
"""Time between two requests for the outcome, s."""
_AT_ONCE = 16
"""Maximum number of requests in one tick; the socket takes turns among its clients."""

Do = Callable[[str, dict[str, Any]], dict[str, Any]]
"""Carries out a verb with its details and returns the answer's details; raises Refused."""


class LocalControl(Protocol):
    """Takes requests of a person at the site: `LocalControlSocket` has a socket, a test bed has memory."""

    def serve(self, now_ns: int, do: Do) -> None:
        """Carry out and answer the requests since the last call."""


class OwnerSocket:
    """A socket on loopback that admits only the owner of the site's secret key. Never blocks."""

    def __init__(self, kind: int, port: int, keys: KeyPair, domain: str):
        """Bind; raises LinkProblem where the port is in use."""
        self._context = zmq.Context()
        # Handshakes are not limited, so that frequent requests for the status never keep out an emergency stop.
        self._authenticator = Authenticator(self._context, lambda _, key: key == keys.public, limited=False)
        self._socket: zmq.Socket[bytes] = self._context.socket(kind)
        prepare_socket(self._socket)
        self._prepare(port)
        serve_curve(self._socket, keys, domain)
        try:
            self._socket.bind(f"tcp://{HOST}:{port}")
        except zmq.ZMQError as error:
            self.close()
            raise LinkProblem(f"{HOST}:{port} ({domain}): {error.strerror}; choose another {domain}_port") from None

    def _prepare(self, port: int) -> None:
        """Set further options of the socket, before it is bound."""

    def close(self) -> None:
        """Release the port."""
        self._authenticator.close()
        self._context.destroy(linger=0)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class LocalControlSocket(OwnerSocket):
    """The site's side."""

    def __init__(self, port: int, keys: KeyPair):
        """Bind; raises LinkProblem."""
        super().__init__(zmq.ROUTER, port, keys, "desk")
        self._inbox = Inbox(self._socket)

    def serve(self, now_ns: int, do: Do) -> None:
        """Carry out and answer the requests since the last call."""
        for sender, packet in receive_requests(self._inbox, _AT_ONCE):
            try:
                request = Request.decode(packet)
            except BadPacket:
                continue
            refused, details = "", {}
            try:
                details = do(request.verb, request.details)
            except (Refused, BadPacket) as error:  # BadPacket: too long for a packet to the far site
                refused = str(error)[:LONGEST_REFUSAL]
            send_answer(self._socket, sender.who, Answer(0, request.sequence, now_ns, refused, details).encode())
            self._inbox.stale()


def stop_from_desk(port: int, keys: KeyPair) -> str:
    """Ask a running site for an emergency stop; return what its devices and those of the far site confirm.

    Raises:
        LinkProblem: no site takes the request.
    """
    ask_desk(port, keys, "estop")
    until_s = time.monotonic() + _OUTCOME_S
    while time.monotonic() < until_s:
        with suppress(LinkProblem):  # the stop was taken; a site that is silent now has still stopped
            if outcome := ask_desk(port, keys, "status")["estop"]:
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
        status = ask_desk(port, keys, "status")
        here, far = said_fault(status["fault"]), said_fault(status.get("remote_fault"))
        if not here and not far:
            return
        if far and (refusal := status.get("refusal")):
            raise Refused(f"the far site says: {refusal}")
        if time.monotonic() >= until_s:
            raise Refused(f"still latched: {here or f'{far} (at the far site)'}")
        time.sleep(_ASK_AGAIN_S)


def ask_desk(port: int, keys: KeyPair, verb: str, details: dict[str, Any] | None = None) -> dict[str, Any]:
    """Send a request to a running site on this machine; return the details of its answer.

    Raises:
        LinkProblem: no site answers there.
        Refused: the site refuses; the message says why.
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
