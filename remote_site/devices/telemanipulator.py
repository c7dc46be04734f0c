"""Drives the telemanipulator on CAN: sends set-points, reads positions and contact forces."""

from collections.abc import Sequence
from dataclasses import dataclass

from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameReceiver, FrameSender
from common.buses.can_port import CanPort
from common.buses.drive_monitor import CommandMonitor, DriveMonitor, ReportMonitor
from common.buses.wiring import SYSTEM, Wiring
from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.limits import GAP_S
from common.timing.standstill import HostClock, Witness
from common.timing.timeouts import FRAME_S
from remote_site.devices.hand_sensor_checks import HandSensorChecks

_MM = 1000.0
_NEVER = float("-inf")


@dataclass(slots=True)
class Measured:
    """Place of the remote hand, m, and contact forces, N, each from the newest frame of its kind."""

    x_m: float = 0.0
    y_m: float = 0.0
    z_m: tuple[float, ...] = (0.0,) * len(FINGERS)
    force_n: tuple[float, ...] = (0.0,) * len(FINGERS)
    pose_s: float = _NEVER
    heights_s: float = _NEVER
    force_s: float = _NEVER

    @property
    def oldest_s(self) -> float:
        """Arrival time of the oldest part, s; -inf until all parts have arrived."""
        return min(self.pose_s, self.heights_s, self.force_s)


@dataclass(slots=True)
class Following:
    """Last report of the telemanipulator's state.

    Attributes:
        released: whether it is in its safe state: the hand stays, and fingers only rise.
        hand_alive, heights_alive: whether set-points of each kind reach it.
        reported_s: time of the report, s; -inf before the first.
    """

    released: bool = False
    hand_alive: bool = False
    heights_alive: bool = False
    reported_s: float = _NEVER


class Telemanipulator:
    """The remote hand."""

    def __init__(
        self,
        address: CanAddress,
        fingers: Sequence[str] = FINGERS,
        clock: HostClock | None = None,
        wiring: Wiring = SYSTEM,
    ):
        """Open the bus at `address` in the background for these `fingers`; `clock` gives the times of `read`."""
        frames = ("HandPoseMeasured", "FingerHeightsMeasured", "ContactForces", "TelemanipulatorState")
        self.receivers = tuple(FrameReceiver(name) for name in frames)
        self.line = CanPort(address, self.receivers, sends=("HandSetpoint", "HeightSetpoint"), wiring=wiring)
        self.measured = Measured()
        self.following = Following()
        self.stood_still_s = 0.0
        """Duration of a standstill of the host's clock before the last `read`, by the number of frames, s."""
        self._clock = HostClock() if clock is None else clock
        self._witness = Witness()
        self._fingers = fingers
        self._watched = HandSensorChecks(fingers)
        self._hand = FrameSender("HandSetpoint")
        self._heights = FrameSender("HeightSetpoint")
        self._release_obeys = DriveMonitor(FaultCode.NOT_RELEASED)
        self._state_comes = ReportMonitor()
        self.commands = CommandMonitor()
        self._disobeys: Fault | None = None

    def read(self, t_s: float, *, stood_still: bool = False) -> Measured:
        """Take the frames since the last call at `t_s`, s; after a standstill, earlier places no longer count."""
        came = self.line.poll()
        self.stood_still_s = self._witness.frames(
            self._clock.now_s(), self.receivers[0].taken, drained=self.line.drained
        )
        if stood_still or self.stood_still_s > 0.0:
            self._watched = HandSensorChecks(self._fingers)
        measured, watched = self.measured, self._watched
        watched.begin()
        # Each frame counts, so that a late site also finds an encoder that jumps from time to time.
        for sent_s, (x_mm, y_mm) in came.get("HandPoseMeasured", ()):
            measured.x_m, measured.y_m = watched.pose(sent_s, x_mm / _MM, y_mm / _MM)
            measured.pose_s = t_s
        z_m: tuple[float, ...] = ()
        for sent_s, heights_mm in came.get("FingerHeightsMeasured", ()):
            z_m = tuple([height_mm / _MM for height_mm in heights_mm])
            measured.z_m = watched.heights(sent_s, z_m)
            measured.heights_s = t_s
        if z_m:
            watched.servos(sent_s, z_m)
        if forces := came.get("ContactForces"):
            sent_s, measured.force_n = forces[-1]
            measured.force_s = t_s
            watched.forces(sent_s, measured.force_n)
        self._state_comes.step(self.receivers[0].taken, self.receivers[3].taken)
        if states := came.get("TelemanipulatorState"):
            released, hand_alive, heights_alive = states[-1][1]
            self.following = Following(released > 0.0, hand_alive > 0.0, heights_alive > 0.0, reported_s=t_s)
            self.commands.reported(t_s + self.stood_still_s, hand_alive > 0.0 and heights_alive > 0.0)
            self._disobeys = self._release_obeys.reported(t_s + self.stood_still_s, not self.following.released)
        return measured

    @property
    def unread_s(self) -> float:
        """Time that the telemanipulator took to send the unread frames, s."""
        return self.line.unread("HandPoseMeasured") * FRAME_S

    def faults(self, t_s: float) -> list[Fault]:
        """Return the faults of bus, drives and sensors at `t_s`, s; without reports, of the bus alone."""
        found = [self.line.fault] if self.line.fault else []
        here = self.line.connected and t_s - self.measured.oldest_s <= GAP_S
        if self._disobeys and t_s - self.following.reported_s <= GAP_S:
            found.append(self._disobeys)
        if not here:
            return found
        unreported = self._state_comes.fault
        return found + ([unreported] if unreported else []) + self._watched.faults

    def unconfirmed(self, since_s: float) -> str:
        """Return why it may not be released; empty when a report after `since_s`, s, says that it is."""
        if not self.line.connected:
            return "not connected"
        if not self.following.reported_s > since_s:
            return "no report"
        return "" if self.following.released else "not released"

    def move(self, t_s: float, x_m: float, y_m: float, z_m: list[float], *, released: bool) -> None:
        """Send set-points of the hand and its five fingertips, m; released, the hand stays and fingers only rise."""
        hand = self._hand.next_frame((x_m * _MM, y_m * _MM))
        heights = self._heights.next_frame([*[height_m * _MM for height_m in z_m], float(released)])
        self._watched.commanded(t_s, z_m, released)
        self._release_obeys.commanded(t_s, not released)
        self.commands.commanded(t_s)
        self.line.send(hand, heights)
