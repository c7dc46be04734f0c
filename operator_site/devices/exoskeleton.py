"""Driver of the hand-force exoskeleton on CAN: the hand's pose and fingertips' heights in, finger forces out."""

from collections.abc import Sequence
from dataclasses import dataclass

from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameReceiver, FrameSender
from common.buses.can_port import CanPort
from common.buses.drive_monitor import CommandMonitor, DriveMonitor, ForceMonitor, ReportMonitor
from common.buses.encoder_glitches import FINGER_M_S, HAND_M_S, EncoderGlitches
from common.buses.wiring import SYSTEM, Wiring
from common.faults.fault import AXES, Fault, FaultCode
from common.fingers import FINGERS
from common.limits import GAP_S
from common.timing.standstill import HostClock, Witness
from common.timing.timeouts import FRAME_S
from operator_site.coupling.coupling import AT_ORIGIN, Places
from operator_site.devices.stuck_joint import StuckJoints

_MM = 1000.0
_NEVER = float("-inf")


@dataclass(slots=True)
class Hand:
    """Place of the operator's hand, and times of the frames that it is from, s: of the pose, and of the heights."""

    place: Places = AT_ORIGIN
    pose_s: float = _NEVER
    heights_s: float = _NEVER

    @property
    def oldest_s(self) -> float:
        """Arrival time of the older part, s; -inf until both parts have arrived."""
        return min(self.pose_s, self.heights_s)


@dataclass(slots=True)
class Pushing:
    """Last report of the exoskeleton's outputs: force on each finger, N, and whether the drives are enabled."""

    force_n: tuple[float, ...] = (0.0,) * len(FINGERS)
    enabled: bool = False
    reported_s: float = _NEVER


class Exoskeleton:
    """The hand-force exoskeleton."""

    def __init__(
        self,
        address: CanAddress,
        fingers: Sequence[str] = FINGERS,
        clock: HostClock | None = None,
        wiring: Wiring = SYSTEM,
    ):
        """Open the bus at `address` in the background for these `fingers`; `clock` gives the times of `read`."""
        self.receivers = tuple(FrameReceiver(name) for name in ("HandPose", "FingerHeights", "ExoskeletonState"))
        self.line = CanPort(address, self.receivers, sends=("FingerForces",), wiring=wiring)
        self.hand = Hand()
        self.pushing = Pushing()
        self.stood_still_s = 0.0
        """Duration of a standstill of the host's clock before the last `read`, by the number of frames, s."""
        self._clock = HostClock() if clock is None else clock
        self._witness = Witness()
        self._taking_part = [finger in fingers for finger in FINGERS]
        self._begin_checks()
        self._forces = FrameSender("FingerForces")
        self._forces_obey = ForceMonitor()
        self._enabled_obeys = DriveMonitor(FaultCode.DRIVES_UNASKED)
        self._state_comes = ReportMonitor()
        self.commands = CommandMonitor()
        self._disobeys: list[Fault] = []

    def read(self, t_s: float, *, stood_still: bool = False) -> Hand:
        """Take the frames since the last call at `t_s`, s; after a standstill, earlier places no longer count."""
        came = self.line.poll()
        self.stood_still_s = self._witness.frames(
            self._clock.now_s(), self.receivers[0].taken, drained=self.line.drained
        )
        if stood_still or self.stood_still_s > 0.0:
            self._begin_checks()
        hand = self.hand
        self._pose_glitches.begin()
        self._height_glitches.begin()
        # Each frame counts, so that a late site also finds an encoder that jumps from time to time.
        for sent_s, (x_mm, y_mm) in came.get("HandPose", ()):
            _, (x_m, y_m) = self._pose_glitches.step(sent_s, (x_mm / _MM, y_mm / _MM))
            hand.place, hand.pose_s = Places(x_m, y_m, hand.place.z_m), t_s
        for sent_s, heights_mm in came.get("FingerHeights", ()):
            read_m = tuple([height_mm / _MM for height_mm in heights_mm])
            dt_s, z_m = self._height_glitches.step(sent_s, read_m)
            x_m, y_m, _ = hand.place
            self._stuck_joints.step(dt_s, read_m, (x_m, y_m), self.pushing.force_n)
            hand.place, hand.heights_s = Places(x_m, y_m, z_m), t_s
        self._state_comes.step(self.receivers[0].taken, self.receivers[2].taken)
        if states := came.get("ExoskeletonState"):
            *force_n, enabled = states[-1][1]
            self._take_state(t_s + self.stood_still_s, tuple(force_n), enabled > 0.0)
        return hand

    def _begin_checks(self) -> None:
        """Check encoders and joints without a memory of earlier frames."""
        self._pose_glitches = EncoderGlitches(AXES, HAND_M_S)
        self._height_glitches = EncoderGlitches(FINGERS, FINGER_M_S)
        self._stuck_joints = StuckJoints(self._taking_part)

    def _take_state(self, t_s: float, force_n: tuple[float, ...], enabled: bool) -> None:
        """Compare the reported outputs with the commands."""
        self.pushing = Pushing(force_n, enabled, t_s)
        self.commands.reported(t_s, enabled)
        unasked = self._enabled_obeys.reported(t_s, enabled)
        self._disobeys = self._forces_obey.reported(t_s, force_n)
        if unasked:
            self._disobeys.append(unasked)

    @property
    def unread_s(self) -> float:
        """Time that the exoskeleton took to send the unread frames, s."""
        return self.line.unread("HandPose") * FRAME_S

    def faults(self, t_s: float) -> list[Fault]:
        """Return the faults of bus, drives, encoders and joints at `t_s`, s; without reports, of the bus alone."""
        found = [self.line.fault] if self.line.fault else []
        here = self.line.connected and t_s - self.hand.oldest_s <= GAP_S
        if t_s - self.pushing.reported_s <= GAP_S:
            found += self._disobeys
        if here:
            if unreported := self._state_comes.fault:
                found.append(unreported)
            found += self._pose_glitches.faults + self._height_glitches.faults + self._stuck_joints.faults
        return found

    def unconfirmed(self, since_s: float) -> str:
        """Return why a finger may still be pushed; empty when a report after `since_s`, s, excludes it."""
        if not self.line.connected:
            return "not connected"
        pushing = self.pushing
        if not pushing.reported_s > since_s:
            return "no report"
        if any(pushing.force_n):
            return f"pushes with up to {max(pushing.force_n):.2f} N"
        return "enabled" if pushing.enabled else ""

    def push(self, t_s: float, force_n: list[float], enabled: bool) -> None:
        """Send the force on each finger, N; without an engaged session, the drives stay off."""
        self._forces_obey.commanded(t_s, force_n if enabled else [0.0] * len(FINGERS))
        self._enabled_obeys.commanded(t_s, enabled)
        if enabled:
            self.commands.commanded(t_s)
        self.line.send(self._forces.next_frame([*force_n, float(enabled)]))
