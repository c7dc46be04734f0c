"""Finds a second sender of one's own frames on a CAN bus.

A bus brings nobody its own frames back. One that is heard was sent by another node or program, and devices obey it.
"""

from collections.abc import Sequence

from common.buses.can_frames import packing
from common.faults.fault import Fault, FaultCode

SETTLING = 500
"""Frames of a new connection, some 0.4 s: what an earlier connection left on its way has come by then."""
CLEAR_AFTER = 1000
"""A bus on which so many frames came without an own one has no second sender any more."""


class DuplicateSender:
    """Watches all frames of one connection.

    Attributes:
        heard: own frames that came after the connection had settled, in all connections.
    """

    def __init__(self, names: Sequence[str]) -> None:
        """`names`: the frames that this host sends."""
        self.heard = 0
        self._names = {packing(name).frame_id: name for name in names}
        self.begin()

    def begin(self) -> None:
        """A new connection."""
        self._seen = 0
        self._last: tuple[int, str] | None = None

    def step(self, frame_id: int) -> bool:
        """Take one frame; returns whether it has an identifier that this host alone may send."""
        self._seen += 1
        if frame_id not in self._names:
            return False
        if self._seen > SETTLING:
            self.heard += 1
            self._last = self._seen, self._names[frame_id]
        return True

    @property
    def fault(self) -> Fault | None:
        """What is wrong; None when nothing is."""
        if self._last is None or self._seen - self._last[0] > CLEAR_AFTER:
            return None
        return Fault(FaultCode.FOREIGN_FRAMES, self._last[1])
