"""Emulate the telemanipulator as a CAN node: it follows set-points and reports positions and forces.

It maintains its safe state by itself, independent of set-points. While it is released, the hand stays in place and the
fingers can only rise. A command releases it, and so does a gap in the height set-points.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from common.buses.can_frames import FrameReceiver, FrameSender, SentFrame
from common.fingers import FINGERS
from sim_sensors.devices.can_node import CanNode

HOVER_M = 0.006


class Telemanipulator(CanNode):
    """Emulated robot hand.

    Attributes:
        clings: fault; the hand ignores a commanded release, but its own time-out still acts.
    """

    def __init__(self) -> None:
        receivers = (FrameReceiver("HandSetpoint"), FrameReceiver("HeightSetpoint"))
        super().__init__(receivers, FrameSender("TelemanipulatorState"))
        self.clings = False
        self._senders = [FrameSender(n) for n in ("HandPoseMeasured", "FingerHeightsMeasured", "ContactForces")]
        self._asked_pose = (0.0, 0.0)
        self._asked_z: NDArray[np.float64] = np.full(len(FINGERS), HOVER_M)
        self._asked_release = True
        self._wanted_pose = (0.0, 0.0)
        self._wanted_z = self._asked_z
        self._pose = (0.0, 0.0)
        self._z_m: Sequence[float] = [HOVER_M] * len(FINGERS)
        self._measured_force_n: Sequence[float] = [0.0] * len(FINGERS)
        self._hand_alive = False
        self._heights_alive = False
        self._hand_stopped = False
        self._fingers_stopped = False

    @property
    def released(self) -> bool:
        """Whether the hand is in its safe state; this is its state from power-up until a command."""
        return self._asked_release or not self._heights_alive

    def measure(self, x_m: float, y_m: float, z_m: Sequence[float], force_n: Sequence[float]) -> None:
        """Take the readings of encoders and force sensors: position, m, heights (5,), m, contact forces (5,), N."""
        self._pose, self._z_m, self._measured_force_n = (x_m, y_m), z_m, force_n

    def setpoint_m(self, now_s: float) -> tuple[float, float, NDArray[np.float64]]:
        """Return the targets of the servos for this step: x, y and the heights (5,), m.

        A stop holds the position measured at that time. The state report describes the latest call.
        """
        self._hand_alive, self._heights_alive = self.alive("HandSetpoint", now_s), self.alive("HeightSetpoint", now_s)
        released = self.released
        hand_stops = released or not self._hand_alive
        if not hand_stops:
            self._wanted_pose = self._asked_pose
        elif not self._hand_stopped:
            self._wanted_pose = self._pose
        if not released:
            self._wanted_z = self._asked_z
        elif not self._fingers_stopped:
            self._wanted_z = np.array(self._z_m)
        elif self._heights_alive:
            self._wanted_z = np.maximum(self._wanted_z, self._asked_z)
        self._hand_stopped, self._fingers_stopped = hand_stops, released
        return *self._wanted_pose, self._wanted_z

    def _measured(self) -> list[SentFrame]:
        pose, heights, forces = self._senders
        x_m, y_m = self._pose
        return [
            pose.next_frame((x_m * 1e3, y_m * 1e3)),
            heights.next_frame([z_m * 1e3 for z_m in self._z_m]),
            forces.next_frame(self._measured_force_n),
        ]

    def _applied(self) -> Sequence[float]:
        return float(self.released), float(self._hand_alive), float(self._heights_alive)

    def _obey(self, name: str, values: Sequence[float], now_s: float) -> None:
        if name == "HandSetpoint":
            x_mm, y_mm = values
            self._asked_pose = (x_mm * 1e-3, y_mm * 1e-3)
        else:
            *heights_mm, released = values
            self._asked_z = np.array(heights_mm) * 1e-3
            self._asked_release = released > 0.0 and not self.clings
