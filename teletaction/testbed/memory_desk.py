"""The desk of a site in a test bed: a person's requests without a socket."""

from collections import deque
from concurrent.futures import Future
from typing import Any

from common.desk import Do
from common.packets import BadPacket
from common.session import Refused


class MemoryDesk:
    """Both ends of a desk: the site serves it, a person or a console asks."""

    def __init__(self) -> None:
        """Nothing was asked."""
        self._asked: deque[tuple[str, dict[str, Any], Future[dict[str, Any]]]] = deque()

    def serve(self, now_ns: int, do: Do) -> None:
        """As `common.desk.LocalControl.serve`."""
        while self._asked:
            verb, details, answer = self._asked.popleft()
            if not answer.set_running_or_notify_cancel():
                continue
            try:
                answer.set_result(do(verb, details))
            except (Refused, BadPacket) as error:
                answer.set_exception(Refused(str(error)))

    def ask(self, verb: str, details: dict[str, Any] | None = None) -> "Future[dict[str, Any]]":
        """Ask for something in the site's next tick; the future holds the answer, or Refused.

        It waits for a site that stands still. No request is lost, an emergency stop included.
        """
        answer: Future[dict[str, Any]] = Future()
        self._asked.append((verb, details or {}, answer))
        return answer
