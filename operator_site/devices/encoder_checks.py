"""Are the exoskeleton's encoders to be believed? One that jumps is not acted on, and one that is stuck is named."""

from collections.abc import Sequence

from common.buses.encoder_glitches import FINGER_M_S, HAND_M_S, EncoderGlitches
from common.faults.fault import AXES, Fault
from common.fingers import FINGERS
from operator_site.devices.stuck_joint import StuckJoints


class EncoderChecks:
    """Takes each frame's readings and gives the places to act on."""

    def __init__(self, taking_part: Sequence[bool] = (True,) * len(FINGERS)) -> None:
        """Watch the fingers that are in the exoskeleton for standing still, and all encoders for jumps."""
        self._pose, self._heights = EncoderGlitches(AXES, HAND_M_S), EncoderGlitches(FINGERS, FINGER_M_S)
        self._still = StuckJoints(taking_part)
        self._pose_m: tuple[float, float] = (0.0, 0.0)

    def pose(self, sent_s: float, x_m: float, y_m: float) -> tuple[float, float]:
        """The pose to act on, m, for one that was on the bus at `sent_s`, s."""
        _, (x_m, y_m) = self._pose.step(sent_s, (x_m, y_m))
        self._pose_m = x_m, y_m
        return self._pose_m

    def heights(self, sent_s: float, z_m: Sequence[float], pushed_n: Sequence[float]) -> tuple[float, ...]:
        """The heights to act on, (5,), m, for those that were on the bus at `sent_s`, s, under these forces, N."""
        dt_s, believed_m = self._heights.step(sent_s, z_m)
        self._still.step(dt_s, z_m, self._pose_m, pushed_n)
        return tuple(believed_m)

    @property
    def faults(self) -> list[Fault]:
        """What is wrong with which; empty when all is well."""
        return self._pose.faults + self._heights.faults + self._still.faults
