"""How many of the last frames of one kind were damaged. Single ones are refused; many are a fault of their sender.

CAN's own checksum finds what happens on the wire. What still comes with a wrong CRC or a counter that stands still was
wrong before it was sent.
"""

from common.faults.fault import Fault, FaultCode
from common.limits import GAP_S

WINDOW = 50
"""Frames looked back at: 0.1 s at 500 Hz."""
MOST = 10
"""More of them are no accident."""
_LATELY = (1 << WINDOW) - 1


class FrameErrorRate:
    """Watches one kind of frame.

    Attributes:
        fault: what is wrong as of the last frame; None when nothing is.
    """

    __slots__ = ("_good_s", "_history", "_name", "_seen", "fault")

    def __init__(self, name: str) -> None:
        """A new connection; `name` is the frame's, for people."""
        self.fault: Fault | None = None
        self._name = name
        self._history = self._seen = 0
        self._good_s: float | None = None

    def step(self, sent_s: float, damaged: bool) -> None:
        """A frame came, damaged or not.

        Args:
            sent_s: when it was on the bus, by the bus's clock, s.
            damaged: whether it was refused.
        """
        if self._seen < WINDOW:
            self._seen += 1
        if not (damaged or self._history):  # as nearly always: good, and so were all before it
            self._good_s = sent_s
            return
        self._history = (self._history << 1 | damaged) & _LATELY
        if self._good_s is None or not damaged:
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
