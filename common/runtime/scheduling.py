"""Sets the scheduling of threads and processes: a timely loop first, background processes last."""

import ctypes
import gc
import os
import platform
import struct
import sys
from contextlib import suppress
from pathlib import Path

_PR_SET_TIMERSLACK = 29
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}
"""Numbers of the system call sched_setattr, for which there is no function."""
_ATTRIBUTES = struct.Struct("=IIQiIQQQ")
"""Size, policy, flags, nice, priority, slice in ns, deadline and period: `struct sched_attr` of sched_setattr(2)."""
_FLAG_RESET_ON_FORK = 1
_SLICE_NS = 300_000
"""Time slice of a loop's thread, ns: a good part of a tick's work."""
_SWITCH_S = 1e-4
"""Maximum time for which another thread of this process, such as the recording's, holds the interpreter, s."""
_REAL_TIME_PRIORITY = 10
"""Real-time priority of a loop: above all ordinary work, and below the system's own threads (50)."""
_THREADS = Path("/proc/self/task")
_GROUP = Path("/proc/self/autogroup")
"""File of this session's `nice` value, where the kernel shares processors among sessions. There a process's own `nice`
only counts within its session."""


def become_timely() -> None:
    """Prepare this process and thread for a loop that must not be late; call it once, before the loop.

    It excludes objects of the start-up from garbage collection, which would delay the loop by tens of milliseconds.
    It shortens the interpreter's switch interval: by default the loop waits 5 ms, more than two ticks, for a
    computing thread. It requests 1 ns timer slack (Linux; 50 us by default) and short time slices.
    """
    gc.collect()
    gc.freeze()
    sys.setswitchinterval(_SWITCH_S)
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
        for thread in _THREADS.iterdir():
            _ask_for_short_slices(int(thread.name))


def _ask_for_short_slices(thread: int) -> None:
    """Request short time slices: a thread with a shorter slice gets the processor on waking up (Linux >= 6.12).

    Otherwise a console on the same processor finishes its own slice of some milliseconds first. What the system does
    not support or forbids stays unchanged, and so does a real-time policy.
    """
    number = _SCHED_SETATTR.get(platform.machine())
    if number is None or policy(thread) != os.SCHED_OTHER:
        return
    nice = os.getpriority(os.PRIO_PROCESS, thread)
    kept = _FLAG_RESET_ON_FORK if os.sched_getscheduler(thread) & os.SCHED_RESET_ON_FORK else 0
    attributes = _ATTRIBUTES.pack(_ATTRIBUTES.size, os.SCHED_OTHER, kept, nice, 0, _SLICE_NS, 0, 0)
    ctypes.CDLL(None, use_errno=True).syscall(number, thread, attributes, 0)


def policy(thread: int = 0) -> int:
    """Return the scheduling policy of a thread, such as os.SCHED_OTHER; 0 is the calling thread."""
    return os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK


def has_real_time() -> bool:
    """Return whether the calling thread has real-time priority, from any source."""
    return policy() in (os.SCHED_FIFO, os.SCHED_RR)


def take_realtime() -> bool:
    """Set real-time priority for this thread, and none for threads that it starts; return whether that was allowed.

    A thread that already has another policy keeps it: the result is False, too.
    """
    if policy() != os.SCHED_OTHER:
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(_REAL_TIME_PRIORITY))
    except OSError:
        return False
    return True


def take_ordinary(thread: int = 0) -> None:
    """Restore ordinary priority, with short slices, for a real-time thread; 0 is the calling thread."""
    # An ordinary user may not clear the flag.
    os.sched_setscheduler(thread, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))
    _ask_for_short_slices(thread)


def give_way(steps: int) -> None:
    """Raise the `nice` value of this process by `steps`, 0..19, and that of its session where it leads one."""
    os.nice(steps)
    if os.getsid(0) == os.getpid():
        with suppress(OSError):  # a kernel without such groups
            _GROUP.write_text(str(steps), "ascii")


class Starved:
    """Detects that a thread of this process is ready to run but has had no processor since the last look (Linux)."""

    def __init__(self, thread: int) -> None:
        """Look at a thread, given by its number."""
        self._folder = _THREADS / str(thread)
        self._ran_ns = -1

    def look(self) -> bool:
        """Return whether the thread starved; False where the system does not report it."""
        try:
            state = (self._folder / "stat").read_bytes().rpartition(b") ")[2][:1]
            ran_ns = int((self._folder / "schedstat").read_bytes().split()[0])
        except (OSError, ValueError, IndexError):
            return False
        ran, self._ran_ns = ran_ns != self._ran_ns, ran_ns
        return state == b"R" and not ran
