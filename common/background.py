"""Opening a device may take seconds: it happens beside the loop, never in it."""

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class BackgroundOpener(Generic[T]):
    """Runs `opener` in a thread, again and again until it succeeds, and hands the result over once."""

    def __init__(self, opener: Callable[[], T], retry_s: float = 0.25):
        self.problem: Exception | None = None
        """Why the last try failed; None while none has."""
        self.discard: Callable[[T], object] = lambda opened: None
        """Closes what was opened and is wanted no more."""
        self._opener = opener
        self._retry_s = retry_s
        self._opened: T | None = None
        self._stop = threading.Event()
        self._handing = threading.Lock()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin trying; does nothing while a try is under way."""
        if self._thread is None:
            self._stop.clear()
            self._thread = threading.Thread(target=self._run, daemon=True, name="opener")
            self._thread.start()

    def take(self) -> T | None:
        """What was opened, once; None while there is nothing new."""
        opened, self._opened = self._opened, None
        if opened is not None:
            self._thread = None
        return opened

    def stop(self) -> None:
        """Give up; a try under way ends by itself, and what it opens is closed again."""
        with self._handing:
            self._stop.set()
            opened = self.take()
        if opened is not None:
            self.discard(opened)

    def _run(self) -> None:
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
            self.discard(opened)
