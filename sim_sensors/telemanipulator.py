"""The telemanipulator as a CAN node: moves the remote fingers to set-points, tells positions and forces."""

import can
import numpy as np
from numpy.typing import NDArray

from common.can_frames import FrameReceiver, FrameSender, by_finger
from common.fingers import FINGERS
from sim_sensors.can_node import CanNode

HOVER_M = 0.006


class Telemanipulator(CanNode):
    """Emulated robot hand. Without set-points for 100 ms it stops where it is."""

    def __init__(self) -> None:
        super().__init__((FrameReceiver("HandSetpoint"), FrameReceiver("HeightSetpoint")))
        self._senders = [FrameSender(n) for n in ("HandPoseMeasured", "FingerHeightsMeasured", "ContactForces")]
        self._wanted_pose = (0.0, 0.0)
        self._wanted_z: NDArray[np.float64] = np.full(len(FINGERS), HOVER_M)
        self._pose = (0.0, 0.0)
        self._z_m: NDArray[np.float64] = self._wanted_z
        self._measured_force_n: NDArray[np.float64] = np.zeros(len(FINGERS))
        self._stopped_pose = False
        self._stopped_z = False

    def measure(self, x_m: float, y_m: float, z_m: NDArray[np.float64], force_n: NDArray[np.float64]) -> None:
        """What its encoders and force sensors read now: pose, heights (5,), contact forces (5,)."""
        self._pose, self._z_m, self._measured_force_n = (x_m, y_m), z_m, force_n

    def setpoint_m(self, now_s: float) -> tuple[float, float, NDArray[np.float64]]:
        """Where its servos go now: x, y and the heights (5,), m.

        Each half that has run out of commands is frozen at what was measured at that moment.
        """
        pose_alive, z_alive = self.alive("HandSetpoint", now_s), self.alive("HeightSetpoint", now_s)
        if not pose_alive and not self._stopped_pose:
            self._wanted_pose = self._pose
        if not z_alive and not self._stopped_z:
            self._wanted_z = self._z_m.copy()
        self._stopped_pose, self._stopped_z = not pose_alive, not z_alive
        return *self._wanted_pose, self._wanted_z

    def take_frames(self) -> list[can.Message]:
        """HandPoseMeasured, FingerHeightsMeasured and ContactForces with what was measured last."""
        pose = {"x": self._pose[0] * 1e3, "y": self._pose[1] * 1e3}
        heights = dict(zip(FINGERS, (self._z_m * 1e3).tolist(), strict=True))
        forces = dict(zip(FINGERS, self._measured_force_n.tolist(), strict=True))
        values: tuple[dict[str, float], ...] = (pose, heights, forces)
        return [sender.encode(each) for sender, each in zip(self._senders, values, strict=True)]

    def _obey(self, name: str, values: dict[str, float], now_s: float) -> None:
        if name == "HandSetpoint":
            self._wanted_pose = (values["x"] * 1e-3, values["y"] * 1e-3)
        else:
            self._wanted_z = np.array(by_finger(values)) * 1e-3
