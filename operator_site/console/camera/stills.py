"""Chooses the pictures of which still pictures are made, for browsers that cannot decode the stream."""

import logging
import math
from collections.abc import Callable
from concurrent.futures import Future

from operator_site.console.camera.camera_picture import Picture, follows

log = logging.getLogger(__name__)

STILL_S = 0.5
"""Shortest interval between two still pictures, s."""
_MOST = 300
"""Maximum number of pictures that wait; after more, a key picture is needed."""


class Stills:
    """Makes the newest picture a still one, at most once in STILL_S. Pure but for `make`: times are arguments, s.

    Attributes:
        newest: the newest still picture; None without one.
    """

    def __init__(self, make: "Callable[[list[Picture]], Future[Picture]]") -> None:
        """Begin without a picture.

        Args:
            make: begins to make a still picture of the last one of pictures that follow each other.
        """
        self._make = make
        self.newest: Picture | None = None
        self._waiting: list[Picture] = []
        self._sequence: int | None = None
        """Sequence of the newest picture that can be decoded; None until the next key picture."""
        self._running: Future[Picture] | None = None
        self._outdated = False
        """Whether the running one is of pictures before a jump."""
        self._began_s = -math.inf

    @property
    def wants_key(self) -> bool:
        """Whether nothing can be decoded before the next key picture."""
        return self._sequence is None

    def clear(self) -> None:
        """Forget all pictures, as before a jump."""
        self.newest, self._sequence, self._outdated = None, None, True
        self._waiting.clear()

    def take(self, picture: Picture) -> None:
        """Take the next picture of the stream."""
        if picture.is_key or len(self._waiting) >= _MOST or not follows(picture, self._sequence):
            self._waiting.clear()  # nothing before a key picture is needed
            self._sequence = None
        if follows(picture, self._sequence):
            self._waiting.append(picture)
            self._sequence = picture.sequence

    def step(self, now_s: float, *, wanted: bool) -> Picture | None:
        """Return the still picture that was made since the last call, and begin the next one if it is due.

        Args:
            now_s: time, s.
            wanted: whether a page would receive one.
        """
        made = None
        if self._running is not None:
            if not self._running.done():
                return None
            made, self._running = self._result(self._running), None
        if wanted and self._waiting and now_s - self._began_s >= STILL_S:
            self._began_s, self._outdated = now_s, False
            self._running = self._make(self._waiting.copy())
            self._waiting.clear()
        return made

    def _result(self, running: "Future[Picture]") -> Picture | None:
        try:
            made = running.result()
        except (ValueError, OSError, EOFError) as error:
            log.warning("no still picture: %s", error)
            self._waiting.clear()
            self._sequence = None
            return None
        if self._outdated:
            return None
        self.newest = made
        return made
