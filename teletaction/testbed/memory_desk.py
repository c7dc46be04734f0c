"""The desk of a site in a test bed: a person's requests without a socket."""

from typing import Any

from common.desk import Do
from common.packets import BadPacket
from common.session import Refused


class MemoryDesk:
    """Takes requests for the site's next tick; see `common.desk.LocalControl`."""

    def __init__(self) -> None:
        """Nothing was asked."""
        self._asked: tuple[str, dict[str, Any]] | None = None
        self._answer: dict[str, Any] | Exception | None = None

    def serve(self, now_ns: int, do: Do) -> None:
        """As `LocalControl.serve`."""
        if self._asked is None:
            return
        (verb, details), self._asked = self._asked, None
        try:
            self._answer = do(verb, details)
        except (Refused, BadPacket) as error:
            self._answer = Refused(str(error))

    def ask(self, verb: str, details: dict[str, Any] | None = None) -> None:
        """Ask for something in the site's next tick."""
        self._asked, self._answer = (verb, details or {}), None

    def answer(self) -> dict[str, Any] | None:
        """What the site has answered; None while it has not.

        Raises:
            Refused: it will not, and says why.
        """
        if isinstance(self._answer, Exception):
            raise self._answer
        return self._answer
