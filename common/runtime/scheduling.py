"""Who gets a processor first: a loop that must not be late, before a process that stands back."""

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
"""Numbers of the system call, for which there is no function."""
_ATTRIBUTES = struct.Struct("=IIQiIQQQ")
"""Size, policy, flags, nice, priority, slice in ns, deadline and period: `struct sched_attr` of sched_setattr(2)."""
_FLAG_RESET_ON_FORK = 1
_SLICE_NS = 300_000
"""For so long a loop's thread may hold a processor against others: a good part of a tick's work."""
_SWITCH_S = 1e-4
"""Within so long another thread of this process, the recording's above all, lets the loop have the interpreter."""
_REAL_TIME_PRIORITY = 10
"""Above all ordinary work, and below the system's own threads (50)."""
_THREADS = Path("/proc/self/task")
_GROUP = Path("/proc/self/autogroup")
"""Where the kernel shares out processors among sessions of processes, `nice` only counts within one of them."""


def become_timely() -> None:
    """Prepare this process, and this thread of it, for a loop that must not be late; called once, before the loop.

    Takes what start-up left in memory out of the garbage collector's sight: looking through it again and again would
    hold the loop for tens of milliseconds. Has other threads give up the interpreter soon: by default the loop waits
    5 ms for one that computes, more than two ticks. Asks the kernel for 1 ns timer slack (Linux; 50 us by default) and
    for short time slices.
    """
    gc.collect()
    gc.freeze()
    sys.setswitchinterval(_SWITCH_S)
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
        for thread in _THREADS.iterdir():
            _ask_for_short_slices(int(thread.name))


def _ask_for_short_slices(thread: int) -> None:
    """Who asks for a shorter slice than the one who has the processor gets it on waking up (Linux >= 6.12).

    Without, a console on the same processors is let finish its own of some milliseconds. What the system
    does not know, or forbids, stays as it was; so does a real-time policy.
    """
    number = _SCHED_SETATTR.get(platform.machine())
    if number is None or policy(thread) != os.SCHED_OTHER:
        return
    nice = os.getpriority(os.PRIO_PROCESS, thread)
    kept = _FLAG_RESET_ON_FORK if os.sched_getscheduler(thread) & os.SCHED_RESET_ON_FORK else 0
    attributes = _ATTRIBUTES.pack(_ATTRIBUTES.size, os.SCHED_OTHER, kept, nice, 0, _SLICE_NS, 0, 0)
    ctypes.CDLL(None, use_errno=True).syscall(number, thread, attributes, 0)


def policy(thread: int = 0) -> int:
    """What a thread is scheduled by, os.SCHED_OTHER or another; 0 is the calling one."""
    return os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK


def has_real_time() -> bool:
    """Whether the calling thread comes before all ordinary work, whoever gave it that policy."""
    return policy() in (os.SCHED_FIFO, os.SCHED_RR)


def come_first() -> bool:
    """Real-time priority for this thread, and for none that it starts later; False where that is not allowed.

    A thread that has a policy of its own already got it from somebody else, and keeps it: False as well.
    """
    if policy() != os.SCHED_OTHER:
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(_REAL_TIME_PRIORITY))
    except OSError:
        return False
    return True


def stand_in_line(thread: int = 0) -> None:
    """Ordinary priority again for a thread that came first, with short slices; 0 is the calling one."""
    # An ordinary user may not take the flag back.
    os.sched_setscheduler(thread, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))
    _ask_for_short_slices(thread)


def give_way(steps: int) -> None:
    """Lower this process's priority by `steps` of `nice`, 0..19, and that of its session where it leads one."""
    os.nice(steps)
    if os.getsid(0) == os.getpid():
        with suppress(OSError):  # a kernel that knows no such groups
            _GROUP.write_text(str(steps), "ascii")


class Starved:
    """Whether a thread of this process is ready to run, and has had no processor since the last look (Linux)."""

    def __init__(self, thread: int) -> None:
        """Look at a thread, by its number."""
        self._folder = _THREADS / str(thread)
        self._ran_ns = -1

    def look(self) -> bool:
        """Return it; False where the system does not say."""
        try:
            state = (self._folder / "stat").read_bytes().rpartition(b") ")[2][:1]
            ran_ns = int((self._folder / "schedstat").read_bytes().split()[0])
        except (OSError, ValueError, IndexError):
            return False
        ran, self._ran_ns = ran_ns != self._ran_ns, ran_ns
        return state == b"R" and not ran
