"""Ends the process when its loop stands still although the process runs, so that a supervisor restarts it.

A loop that is ready but gets no processor does not stand still: the machine is busy, and a new process would be late,
too. The devices' own time-outs have made every output safe long before. A hang of the whole interpreter also stops
this watchdog. The supervisor's watchdog, which the loop notifies, covers that case.
"""

import faulthandler
import logging
import os
import sys
import threading
from collections.abc import Callable

from common.runtime.scheduling import Starved
from common.timing.timeouts import SITE_WATCHDOG_S

log = logging.getLogger(__name__)

WAKE_UP_S = 0.1
_MOST_WAKE_UPS = round(SITE_WATCHDOG_S / WAKE_UP_S)
"""Number of wake-ups without a tick at which the loop stands still."""
EXIT_CODE = os.EX_SOFTWARE
"""Exit code of the process: 70, an internal error."""
_LAST_WORDS_S = 0.5
_LONGEST_STACKS = 64 * 1024


class Standstill:
    """Counts its own wake-ups, instead of time, since the loop's last tick.

    A stopped process or a sleeping machine makes no wake-ups, just as its loop makes no ticks. Wake-ups at which the
    loop's thread had no processor do not count.
    """

    def __init__(self) -> None:
        self._ticks = -1
        self._wake_ups = 0

    def wake_up(self, ticks: int, starved: bool) -> bool:
        """Count a wake-up, every WAKE_UP_S, and the loop's ticks; return whether it has stood still for too long.

        A `starved` thread was ready since the last wake-up, but had no processor.
        """
        if ticks != self._ticks:
            self._ticks, self._wake_ups = ticks, 0
            return False
        self._wake_ups += not starved
        return self._wake_ups >= _MOST_WAKE_UPS


def end_process() -> None:
    """Write the stacks of all threads and end at once, because the hang would also block an orderly end."""
    # A write to standard error may block as the loop does: it must not delay the end.
    writer = threading.Thread(target=_write_stacks, daemon=True, name="last-words")
    writer.start()
    writer.join(_LAST_WORDS_S)
    os._exit(EXIT_CODE)


def _write_stacks() -> None:
    # The dump holds the interpreter, so it goes to memory first: only the write below may block.
    stacks = os.memfd_create("stacks")
    faulthandler.dump_traceback(stacks)
    os.write(sys.stderr.fileno(), os.pread(stacks, _LONGEST_STACKS, 0))
    log.critical("the loop makes no tick any more: this process ends with exit code %d", EXIT_CODE)


class LoopWatchdog:
    """A thread that watches the loop of the calling thread during the `with` block."""

    def __init__(self, ticks: Callable[[], int], end: Callable[[], None] = end_process) -> None:
        """Watch the loop's count of `ticks`; call `end` when the loop stands still."""
        self._ticks = ticks
        self._end = end
        self._standstill = Standstill()
        self._starved = Starved(threading.get_native_id())
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True, name="watchdog")

    def __enter__(self) -> "LoopWatchdog":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._stop.wait(WAKE_UP_S):
            if self._standstill.wake_up(self._ticks(), self._starved.look()):
                self._end()
                return
