"""Interface of the operator site to its session, with a remote site or with a scene at the other end."""

from collections.abc import Sequence
from typing import Protocol

from common.faults.fault import Fault
from common.link.clock_offset import ClockOffset
from common.link.emergency_stop import Unconfirmed
from common.site_status import SessionEnd
from common.wire.messages import Touch
from common.wire.noted_consent import NotedConsent
from operator_site.session.remote_status import RemotePatient


class SessionProtocol(SessionEnd, Protocol):
    """The operator site's end of the session. Time is an argument, ns of this site's monotonic clock."""

    want_engaged: bool
    """Whether to engage as soon as everything is ready; a fault clears it, because engaging is a deliberate act."""

    @property
    def engages_itself(self) -> bool:
        """Whether the site engages without a person, in each session."""

    @property
    def touch(self) -> Touch | None:
        """The newest touch of this session."""

    @property
    def touch_packet(self) -> bytes:
        """Bytes of the newest touch."""

    @property
    def clock(self) -> ClockOffset:
        """Offset of the other end's clock."""

    @property
    def remote_fault(self) -> Fault | None:
        """The fault latched at the other end; None without one."""

    @property
    def remote_recording(self) -> str:
        """Reason why the recording at the other end stopped; empty while it works or if unknown."""

    @property
    def remote_stale(self) -> str:
        """Since when no motion arrives at the other end, while this end is engaged; empty otherwise."""

    @property
    def remote_patient(self) -> RemotePatient | None:
        """What the other end last reported of its patient; None without a pain slider."""

    @property
    def patient_ns(self) -> int:
        """Time of that report, ns."""

    @property
    def refusal(self) -> str:
        """Reason of the other end's last refusal; empty without one."""

    @property
    def calibrated(self) -> str:
        """Calibration of the other end, for people; empty if unknown."""

    @property
    def roughness_um(self) -> dict[str, float] | None:
        """Scale of roughness in um of the other end; None if it was not calibrated."""

    @property
    def remote_consent(self) -> NotedConsent | None:
        """What the other end has noted of the patient's consent; None while it is unknown."""

    @property
    def spared(self) -> int:
        """Number of motions omitted because no change was perceptible."""

    def step(self, now_ns: int, not_ready: str, unconfirmed: Unconfirmed) -> None:
        """Take one tick; see `SessionClient.step`."""

    def send_motion(self, now_ns: int, x_m: float, y_m: float, z_m: Sequence[float]) -> bytes | None:
        """Send the hand's place and the fingertips' heights (5,), m; return the packet, None where none was sent."""

    def engage(self) -> None:
        """Request engaging for a person."""

    def stop(self, now_ns: int) -> None:
        """Stop in an emergency: latch at once."""

    def disengage(self, now_ns: int, why: str = "") -> None:
        """Bring all outputs to neutral; engaging again needs a new request."""

    def clear(self, now_ns: int) -> None:
        """Clear the latched fault; raises Refused without one."""

    def annotate(self, now_ns: int, text: str) -> None:
        """Note a text for the recording."""

    def goodbye(self, now_ns: int) -> None:
        """Leave the session."""
