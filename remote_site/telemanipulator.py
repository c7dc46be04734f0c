"""Driver of the telemanipulator on CAN: set-points out, positions and contact forces in."""

from dataclasses import dataclass

from common.can_frames import FrameReceiver, FrameSender, by_finger
from common.can_line import CanAddress, CanLine
from common.fingers import FINGERS

_MM = 1000.0
_NEVER = float("-inf")


@dataclass(slots=True)
class Measured:
    """Where the remote hand is and what its fingers feel; the newest of each frame, SI."""

    x_m: float = 0.0
    y_m: float = 0.0
    z_m: tuple[float, ...] = (0.0,) * len(FINGERS)
    force_n: tuple[float, ...] = (0.0,) * len(FINGERS)
    pose_s: float = _NEVER
    heights_s: float = _NEVER
    force_s: float = _NEVER

    @property
    def oldest_s(self) -> float:
        """When the part that was measured longest ago came in, s; -inf until all parts came once."""
        return min(self.pose_s, self.heights_s, self.force_s)


@dataclass(slots=True)
class Following:
    """What the telemanipulator reported last that it does."""

    released: bool = False
    """In its safe state: the hand stays, fingers only rise."""
    hand_alive: bool = False
    heights_alive: bool = False
    """Whether set-points of each kind reach it."""
    reported_s: float = _NEVER


class Telemanipulator:
    """The remote hand."""

    def __init__(self, address: CanAddress):
        """Open the bus at `address` in the background."""
        frames = ("HandPoseMeasured", "FingerHeightsMeasured", "ContactForces", "TelemanipulatorState")
        self.receivers = tuple(FrameReceiver(name) for name in frames)
        self.line = CanLine(address, self.receivers)
        self.measured = Measured()
        self.following = Following()
        self._hand = FrameSender("HandSetpoint")
        self._heights = FrameSender("HeightSetpoint")

    def read(self, t_s: float) -> Measured:
        """Take what came since the last call, stamped with `t_s`."""
        frames = self.line.poll()
        measured = self.measured
        if (pose := frames.get("HandPoseMeasured")) is not None:
            measured.x_m, measured.y_m, measured.pose_s = pose["x"] / _MM, pose["y"] / _MM, t_s
        if (heights := frames.get("FingerHeightsMeasured")) is not None:
            measured.z_m = tuple(height / _MM for height in by_finger(heights))
            measured.heights_s = t_s
        if (forces := frames.get("ContactForces")) is not None:
            measured.force_n, measured.force_s = by_finger(forces), t_s
        if (state := frames.get("TelemanipulatorState")) is not None:
            self.following = Following(
                released=state["released"] > 0.0,
                hand_alive=state["hand_alive"] > 0.0,
                heights_alive=state["heights_alive"] > 0.0,
                reported_s=t_s,
            )
        return measured

    def unconfirmed(self, since_s: float) -> str:
        """Why it is not certain that it is released; empty when the last report, after `since_s`, says so."""
        if not self.line.connected:
            return "not connected"
        if not self.following.reported_s > since_s:
            return "no report"
        return "" if self.following.released else "not released"

    def move(self, x_m: float, y_m: float, z_m: list[float], *, released: bool) -> None:
        """Send set-points of the hand and its five fingertips, m; released, the hand stays and fingers only rise."""
        heights_mm = {finger: height * _MM for finger, height in zip(FINGERS, z_m, strict=True)}
        hand = self._hand.encode({"x": x_m * _MM, "y": y_m * _MM})
        heights = self._heights.encode({"released": float(released), **heights_mm})
        self.line.send(hand)
        self.line.send(heights)
