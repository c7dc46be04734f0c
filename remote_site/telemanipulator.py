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


class Telemanipulator:
    """The remote hand."""

    def __init__(self, address: CanAddress):
        """Open the bus at `address` in the background."""
        self.receivers = tuple(
            FrameReceiver(name) for name in ("HandPoseMeasured", "FingerHeightsMeasured", "ContactForces")
        )
        self.line = CanLine(address, self.receivers)
        self.measured = Measured()
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
        return measured

    def move(self, x_m: float, y_m: float, z_m: list[float]) -> None:
        """Send set-points of the hand and its five fingertips, m."""
        self.line.send(self._hand.encode({"x": x_m * _MM, "y": y_m * _MM}))
        heights = {finger: height * _MM for finger, height in zip(FINGERS, z_m, strict=True)}
        self.line.send(self._heights.encode(heights))
