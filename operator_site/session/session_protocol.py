"""What the operator site needs of its session, whoever is at the other end of it: a remote site, or a scene."""

from collections.abc import Sequence
from typing import Protocol

from common.faults.fault import Fault
from common.link.clock_offset import ClockOffset
from common.link.emergency_stop import Unconfirmed
from common.site_status import SessionEnd
from common.wire.messages import Touch


class SessionProtocol(SessionEnd, Protocol):
    """The operator site's end of the session. Time is an argument, ns of this site's monotonic clock."""

    want_engaged: bool
    """Engage as soon as everything is ready. A fault ends the wish: engaging again is a deliberate act."""

    @property
    def touch(self) -> Touch | None:
        """The newest touch of this session."""

    @property
    def touch_packet(self) -> bytes:
        """Its bytes."""

    @property
    def clock(self) -> ClockOffset:
        """The other end's clock against this site's."""

    @property
    def remote_fault(self) -> Fault | None:
        """The fault that is latched at the other end."""

    @property
    def remote_recording(self) -> str:
        """Why the recording at the other end stopped; empty while it has not, or where that is not known."""

    @property
    def refusal(self) -> str:
        """Why the other end will not; empty when it does."""

    @property
    def calibrated(self) -> str:
        """What the numbers of the other end rest on, for people; empty where it does not say."""

    @property
    def spared(self) -> int:
        """Motions that were not sent because nothing of them would have been felt."""

    def step(self, now_ns: int, not_ready: str, unconfirmed: Unconfirmed) -> None:
        """Go on by one tick; see `SessionClient.step`."""

    def send_motion(self, now_ns: int, x_m: float, y_m: float, z_m: Sequence[float]) -> bytes | None:
        """Send the hand's place and the fingertips' heights (5,), m; return the packet, None where none was sent."""

    def stop(self, now_ns: int) -> None:
        """Emergency stop: latch at once."""

    def disengage(self, now_ns: int, why: str = "") -> None:
        """Bring everything to neutral; engaging again is asked for anew."""

    def clear(self, now_ns: int) -> None:
        """Clear the latched fault; raises Refused when there is none."""

    def annotate(self, now_ns: int, text: str) -> None:
        """Note something for the recording."""

    def goodbye(self, now_ns: int) -> None:
        """Leave."""
