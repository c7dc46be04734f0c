"""Opens a device in a thread, because opening may take seconds and the loop must not wait."""

import math
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

STEADY_S = 1.0
"""Minimum time that a device stays open to be stable, s. A stable device is re-opened at once, another after a wait."""
LONGEST_WAIT_S = 2.0
"""Maximum wait before re-opening, s. The wait doubles each time that a device is lost before STEADY_S."""


class BackgroundOpener(Generic[T]):
    """Runs `opener` in a thread, repeats it until it succeeds, and hands the result over once."""

    def __init__(
        self,
        opener: Callable[[], T],
        retry_s: float = 0.25,
        now_s: Callable[[], float] = time.monotonic,
        discard: Callable[[T], object] = lambda opened: None,
    ) -> None:
        """Open with `opener`; wait `retry_s`, s, after a failure and after a first early loss.

        `discard` closes a device that was opened after `stop`.
        """
        self.problem: Exception | None = None
        """Reason why the last attempt failed; None while no attempt has failed."""
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
        """Start a thread that opens the device; does nothing while one runs."""
        if self._thread is None:
            self._stop.clear()
            steady = self._now_s() - self._taken_s >= STEADY_S
            self._wait_s = 0.0 if steady else min(LONGEST_WAIT_S, max(self._retry_s, 2.0 * self._wait_s))
            self._thread = threading.Thread(target=self._run, daemon=True, name="opener")
            self._thread.start()

    def take(self) -> T | None:
        """Return the opened device once; None while there is no new one."""
        opened, self._opened = self._opened, None
        if opened is not None:
            self._thread = None
            self._taken_s = self._now_s()
        return opened

    def stop(self) -> None:
        """Stop opening; an attempt under way ends by itself, and the device that it opens is closed again."""
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
            except Exception as error:  # a library may raise anything; the next attempt follows
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
