"""Counts damaged frames among the last ones of a kind: single ones are refused, many are a fault of their sender.

CAN's own checksum finds damage on the wire. A frame that arrives with a wrong CRC or an unchanged counter was wrong
before it was sent.
"""

import math

from common.faults.fault import Fault, FaultCode
from common.limits import GAP_S

WINDOW = 50
"""Number of the last frames that are counted: 0.1 s at 500 Hz."""
MOST = 10
"""Maximum number of damaged frames within WINDOW; more are a fault."""
_ALL = (1 << WINDOW) - 1


class FrameErrorRate:
    """Watches one kind of frame.

    Attributes:
        fault: fault as of the last frame; None without one.
    """

    def __init__(self, name: str) -> None:
        """Start a new connection; `name` is the frame's name in faults."""
        self.fault: Fault | None = None
        self._name = name
        self._history = self._seen = 0
        self._good_s: float | None = None
        self._before_s = math.inf
        """Time of the frame before, s."""

    def step(self, sent_s: float, damaged: bool) -> None:
        """Take a frame, sent at `sent_s` on the bus's clock, s; `damaged` if it was refused."""
        if self._seen < WINDOW:
            self._seen += 1
        before_s, self._before_s = self._before_s, sent_s
        if not (damaged or self._history):  # as nearly always: good, and so were all before it
            self._good_s = sent_s
            return
        self._history = (self._history << 1 | damaged) & _ALL
        # After a silence, as of a node that was switched off, damage counts from its first frame.
        if self._good_s is None or not damaged or sent_s - before_s > GAP_S:
            self._good_s = sent_s
        if not self._history:
            self.fault = None
            return
        count = self._history.bit_count()
        if count > MOST:
            seen = str(self._seen)
            self.fault = Fault(FaultCode.FRAMES_DAMAGED, self._name, value=float(count), limit=float(MOST), detail=seen)
        elif sent_s - self._good_s > GAP_S:
            away_ms = (sent_s - self._good_s) * 1e3
            self.fault = Fault(FaultCode.NO_GOOD_FRAME, self._name, value=away_ms, limit=GAP_S * 1e3)
        else:
            self.fault = None
