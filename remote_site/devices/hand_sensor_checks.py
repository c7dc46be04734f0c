"""Is what the telemanipulator measures to be believed? Encoders that jump or are stuck, and force sensors that lie."""

from collections.abc import Sequence

from common.buses.encoder_glitches import FINGER_M_S, HAND_M_S, EncoderGlitches
from common.faults.fault import AXES, Fault
from common.fingers import FINGERS
from remote_site.devices.force_sensor_fault import ForceSensorFault
from remote_site.devices.stuck_encoder import StuckEncoder


class HandSensorChecks:
    """Takes each frame's readings and each set-point, and returns the places to act on."""

    def __init__(self, fingers: Sequence[str] = FINGERS) -> None:
        """Check all encoders for jumps, and the fingers that take part for stuck encoders and faulty force sensors."""
        self._pose, self._heights = EncoderGlitches(AXES, HAND_M_S), EncoderGlitches(FINGERS, FINGER_M_S)
        taking_part = [FINGERS.index(finger) for finger in fingers]
        self._held = [(finger, StuckEncoder()) for finger in taking_part]
        self._sensors = [(finger, ForceSensorFault()) for finger in taking_part]
        self._held_faults: list[Fault] = []
        self._sensor_faults: list[Fault] = []
        self._z_m: Sequence[float] = ()
        self._force_n: Sequence[float] = (0.0,) * len(FINGERS)
        self._force_sent_s = self._height_sent_s = 0.0
        self._set_m: Sequence[float] | None = None

    def begin(self) -> None:
        """Forget jumps of earlier frames; called before the frames of a tick."""
        self._pose.begin()
        self._heights.begin()

    def pose(self, sent_s: float, x_m: float, y_m: float) -> tuple[float, float]:
        """Return the pose to act on, m, from a pose that was on the bus at `sent_s`, s."""
        _, (x_m, y_m) = self._pose.step(sent_s, (x_m, y_m))
        return x_m, y_m

    def heights(self, sent_s: float, z_m: tuple[float, ...]) -> tuple[float, ...]:
        """Return the heights to act on, (5,), m, from heights that were on the bus at `sent_s`, s."""
        _, believed_m = self._heights.step(sent_s, z_m)
        self._z_m = believed_m
        return believed_m

    def servos(self, sent_s: float, z_m: Sequence[float]) -> None:
        """Compare the newest heights (5,), m, as read, with the present set-points and forces.

        Heights that waited to be read are omitted: they followed other set-points. `sent_s` is their time on the bus,
        s.
        """
        dt_s, self._height_sent_s = sent_s - self._height_sent_s, sent_s
        force_n, set_m, found = self._force_n, self._set_m, []
        for finger, held in self._held:
            if fault := held.step(dt_s, z_m[finger], force_n[finger], None if set_m is None else set_m[finger]):
                found.append(fault._replace(where=FINGERS[finger]))
        self._held_faults = found

    def forces(self, sent_s: float, force_n: Sequence[float]) -> None:
        """Take contact forces (5,), N, that were on the bus at `sent_s`, s; heights must arrive before."""
        dt_s, self._force_sent_s, self._force_n = sent_s - self._force_sent_s, sent_s, force_n
        z_m, found = self._z_m, []
        for finger, sensor in self._sensors if z_m else ():
            if fault := sensor.step(dt_s, force_n[finger], z_m[finger]):
                found.append(fault._replace(where=FINGERS[finger]))
        self._sensor_faults = found

    def commanded(self, t_s: float, z_m: Sequence[float], released: bool) -> None:
        """Take set-points (5,), m, sent at `t_s`, s; when released, the fingers move by themselves."""
        self._set_m = None if released else z_m
        for finger, sensor in self._sensors:
            sensor.commanded(t_s, z_m[finger], released)

    @property
    def faults(self) -> list[Fault]:
        """Jumps in the frames of this tick, and all other faults as of the last frames."""
        return self._pose.faults + self._heights.faults + self._held_faults + self._sensor_faults
