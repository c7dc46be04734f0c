"""Emulate the exoskeleton as a CAN node that reports hand pose and fingertip heights and applies finger forces."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from common.buses.can_frames import FrameReceiver, FrameSender, SentFrame
from common.fingers import FINGERS
from common.limits import MODULE_TIMEOUT_S
from sim_sensors.devices.can_node import CanNode

RELEASE_S = 0.050
"""Time in which a force falls to 0 after its command has expired, s."""
_NO_FORCE: NDArray[np.float64] = np.zeros(len(FINGERS))
DRIVEN_S = 1.5
"""Time enabled without a gap before the hand works, s; by then, the remote hand has reached the operator's position."""


class Exoskeleton(CanNode):
    """Emulated exoskeleton of the operator's hand.

    Attributes:
        stuck_n: forces of stuck drives, N, by the finger's index; they override the commands.
    """

    def __init__(self) -> None:
        super().__init__((FrameReceiver("FingerForces"),), FrameSender("ExoskeletonState"))
        self.stuck_n: dict[int, float] = {}
        self._pose_sender = FrameSender("HandPose")
        self._height_sender = FrameSender("FingerHeights")
        self._force_n = _NO_FORCE
        self._enabled = False
        self._applied_n = _NO_FORCE
        self._driven_since_s: float | None = None
        self._pose = (0.0, 0.0)
        self._z_m: Sequence[float] = [0.0] * len(FINGERS)

    def measure(self, x_m: float, y_m: float, z_m: Sequence[float]) -> None:
        """Set the encoder readings: position of the hand, m, and heights of the fingertips (5,), m."""
        self._pose, self._z_m = (x_m, y_m), z_m

    def force_n(self, now_s: float) -> NDArray[np.float64]:
        """Return the forces on the fingers for this step, (5,), N: as commanded, ramped to 0 once the command expires.

        The state report carries the forces of the latest call.
        """
        late_s = self.silent_s("FingerForces", now_s) - MODULE_TIMEOUT_S
        self._applied_n = self._force_n
        if late_s > 0.0:
            self._driven_since_s = None
            self._enabled = False
            self._applied_n = self._force_n * max(0.0, 1.0 - late_s / RELEASE_S)
        if self.stuck_n:
            self._applied_n = self._applied_n.copy()
            self._applied_n[list(self.stuck_n)] = list(self.stuck_n.values())
        return self._applied_n

    def driven(self, now_s: float) -> bool:
        """Return whether the drives were enabled without a gap for `DRIVEN_S`, so that the hand can work."""
        return self._driven_since_s is not None and now_s - self._driven_since_s >= DRIVEN_S

    def _measured(self) -> list[SentFrame]:
        x_m, y_m = self._pose
        return [
            self._pose_sender.next_frame((x_m * 1e3, y_m * 1e3)),
            self._height_sender.next_frame([z_m * 1e3 for z_m in self._z_m]),
        ]

    def _applied(self) -> Sequence[float]:
        return *self._applied_n.tolist(), float(self._enabled)

    def _obey(self, name: str, values: Sequence[float], now_s: float) -> None:
        *force_n, enabled = values
        self._enabled = enabled > 0.0
        self._force_n = np.array(force_n) if self._enabled else _NO_FORCE
        if not self._enabled:
            self._driven_since_s = None
        elif self._driven_since_s is None:
            self._driven_since_s = now_s
