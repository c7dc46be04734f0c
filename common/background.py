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
        self._opener = opener
        self._retry_s = retry_s
        self._opened: T | None = None
        self._stop = threading.Event()
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
        """Give up; a try under way ends by itself and its result is dropped."""
        self._stop.set()

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                self._opened = self._opener()
            except (OSError, ValueError) as error:
                self.problem = error
                self._stop.wait(self._retry_s)
            else:
                self.problem = None
                return
