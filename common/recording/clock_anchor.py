"""Anchors a recording's monotonic times to the wall clock: one pair of readings, taken when the recording begins.

A step of the wall clock during the session changes no recorded time.
"""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple, Self

_READINGS = 5
"""Number of pairs of readings; the one with the smallest uncertainty is kept."""
_KEYS = ("monotonic_ns", "wall_ns", "uncertainty_ns")


class ClockAnchor(NamedTuple):
    """One moment on both clocks of a machine.

    Attributes:
        clock_id: identifies the monotonic clock; times of two clocks cannot be compared.
        monotonic_ns: the moment on the monotonic clock, ns.
        wall_ns: the same moment on the wall clock, ns since 1970 (UTC).
        uncertainty_ns: maximum error of the pair, ns; the wall clock's own error is not part of it.
    """

    clock_id: str
    monotonic_ns: int
    wall_ns: int
    uncertainty_ns: int

    @classmethod
    def now(
        cls, monotonic_ns: Callable[[], int] = time.monotonic_ns, wall_ns: Callable[[], int] = time.time_ns
    ) -> Self:
        """Read both clocks."""
        pairs = []
        for _ in range(_READINGS):
            before, wall, after = monotonic_ns(), wall_ns(), monotonic_ns()
            pairs.append(((after - before + 1) // 2, (before + after) // 2, wall))
        uncertainty, monotonic, wall = min(pairs)
        return cls(clock_id(), monotonic, wall, uncertainty)

    def metadata(self) -> dict[str, str]:
        """Return the anchor as metadata of a recording."""
        return {name: str(value) for name, value in self._asdict().items()}

    @classmethod
    def read(cls, metadata: Mapping[str, str]) -> Self | None:
        """Return the anchor that `metadata` holds; None where it has none, as in recordings of version 0.1.0.

        Raises:
            ValueError: a number is damaged.
        """
        if "clock_id" not in metadata:
            return None
        try:
            return cls(metadata["clock_id"], *(int(metadata[name]) for name in _KEYS))
        except (KeyError, ValueError):
            raise ValueError("the clock anchor in its metadata is damaged") from None

    def wall_time_ns(self, monotonic_ns: int) -> int:
        """Convert a time of the same monotonic clock, ns, to ns since 1970 (UTC)."""
        return monotonic_ns - self.monotonic_ns + self.wall_ns


def clock_id() -> str:
    """Return the identifier of this process's monotonic clock: run of the host, and offsets of the time namespace.

    It is empty where the system gives none. The number of a time namespace does not identify it: a later one may get
    the same number.
    """
    boot = boot_id()
    try:
        offsets = Path("/proc/self/timens_offsets").read_text("ascii").split()
    except OSError:
        return ""
    return " ".join((boot, *offsets)) if boot else ""


def boot_id() -> str:
    """Return the identifier of this run of the host; empty where the system gives none."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
    except OSError:
        return ""
