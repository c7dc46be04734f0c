"""Decides which of many equal log lines is written: a flood of errors must not fill a disk."""

import time
from collections.abc import Callable

QUIET_S = 10.0
"""Between two lines of one kind, s."""


class SparseLog:
    """Counts lines by kind; `due` says whether to write one."""

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        """`now_s`: the clock, s."""
        self._now_s = now_s
        self._written_s: dict[str, float] = {}
        self._left_out: dict[str, int] = {}

    def due(self, kind: str) -> str | None:
        """None while a line of this kind is not due; otherwise what to add about those left out, often empty."""
        now_s = self._now_s()
        written_s = self._written_s.get(kind)
        if written_s is not None and now_s - written_s < QUIET_S:
            self._left_out[kind] = self._left_out.get(kind, 0) + 1
            return None
        self._written_s[kind] = now_s
        left_out = self._left_out.pop(kind, 0)
        return f" ({left_out} more since the last such line)" if left_out else ""
