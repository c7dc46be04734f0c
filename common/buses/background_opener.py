"""Opening a device may take seconds: it happens beside the loop, never in it."""

import math
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

STEADY_S = 1.0
"""What was open for this long is opened again at once, s; what was lost sooner only after a wait."""
LONGEST_WAIT_S = 2.0
"""The wait doubles with each device that is lost as soon as it is open, up to this, s."""


class BackgroundOpener(Generic[T]):
    """Runs `opener` in a thread, again and again until it succeeds, and hands the result over once."""

    def __init__(
        self,
        opener: Callable[[], T],
        retry_s: float = 0.25,
        now_s: Callable[[], float] = time.monotonic,
        discard: Callable[[T], object] = lambda opened: None,
    ) -> None:
        """Open with `opener`; after it failed, and after a first early loss, wait `retry_s`, s.

        `discard` closes what was opened and is wanted no more.
        """
        self.problem: Exception | None = None
        """Why the last try failed; None while none has."""
        self._discard = discard
        self._opener = opener
        self._retry_s = retry_s
        self._now_s = now_s
        self._taken_s = -math.inf
        self._wait_s = 0.0
        self._opened: T | None = None
        self._stop = threading.Event()
        self._handing = threading.Lock()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin trying; does nothing while a try is under way."""
        if self._thread is None:
            self._stop.clear()
            steady = self._now_s() - self._taken_s >= STEADY_S
            self._wait_s = 0.0 if steady else min(LONGEST_WAIT_S, max(self._retry_s, 2.0 * self._wait_s))
            self._thread = threading.Thread(target=self._run, daemon=True, name="opener")
            self._thread.start()

    def take(self) -> T | None:
        """What was opened, once; None while there is nothing new."""
        opened, self._opened = self._opened, None
        if opened is not None:
            self._thread = None
            self._taken_s = self._now_s()
        return opened

    def stop(self) -> None:
        """Give up; a try under way ends by itself, and what it opens is closed again."""
        with self._handing:
            self._stop.set()
            opened = self.take()
        if opened is not None:
            self._discard(opened)

    def _run(self) -> None:
        if self._wait_s > 0.0:
            self._stop.wait(self._wait_s)
        while not self._stop.is_set():
            try:
                opened = self._opener()
            except Exception as error:  # whatever a library raises, the search goes on
                self.problem = error
                self._stop.wait(self._retry_s)
            else:
                self.problem = None
                self._hand_over(opened)
                return

    def _hand_over(self, opened: T) -> None:
        with self._handing:
            wanted = not self._stop.is_set()
            if wanted:
                self._opened = opened
        if not wanted:
            self._discard(opened)
