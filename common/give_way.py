"""A process that stands back where others on its machine want a processor."""

import os
from contextlib import suppress
from pathlib import Path

_GROUP = Path("/proc/self/autogroup")
"""Where the kernel shares out processors among sessions of processes, `nice` only counts within one of them."""


def give_way(steps: int) -> None:
    """Lower this process's priority by `steps` of `nice`, 0..19, and that of its session where it leads one."""
    os.nice(steps)
    if os.getsid(0) == os.getpid():
        with suppress(OSError):  # a kernel that knows no such groups
            _GROUP.write_text(str(steps), "ascii")
