"""Desk of a site in a test bed: it passes a person's requests without a socket."""

from collections import deque
from concurrent.futures import Future
from typing import Any

from common.link.local_control import Do
from common.link.session_state import Refused
from common.wire.packets import BadPacket


class MemoryDesk:
    """Both ends of a desk: the site answers the requests of a person or a console."""

    def __init__(self) -> None:
        """Start without requests."""
        self._asked: deque[tuple[str, dict[str, Any], Future[dict[str, Any]]]] = deque()

    def serve(self, now_ns: int, do: Do) -> None:
        """As `common.link.local_control.LocalControl.serve`."""
        while self._asked:
            verb, details, answer = self._asked.popleft()
            if not answer.set_running_or_notify_cancel():
                continue
            try:
                answer.set_result(do(verb, details))
            except (Refused, BadPacket) as error:
                answer.set_exception(Refused(str(error)))

    def ask(self, verb: str, details: dict[str, Any] | None = None) -> "Future[dict[str, Any]]":
        """Send a request to the site's next tick; the future holds the answer, or Refused.

        A request waits while the site stands still. No request is lost, and no emergency stop.
        """
        answer: Future[dict[str, Any]] = Future()
        self._asked.append((verb, details or {}, answer))
        return answer
