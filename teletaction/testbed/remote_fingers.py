"""Run half a session: simulated remote fingers, identification and pre-heating, without devices, gate or link.

It serves studies with thousands of touches, which would take too long in the whole test bed.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from common.buses.serial_messages import DRIVE_FULL
from common.fingers import FINGERS
from common.scenes.scene import Scene
from common.wire.messages import Touch
from common.wire.packets import LinkState
from remote_site.devices.sensor_frame import PlateReading, SensorFrame
from remote_site.heating import Heating
from remote_site.identification.finger_identification import FingerIdentification
from remote_site.identification.perception import Perception
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable
from sim_sensors.physics.remote_world import RemoteWorld
from sim_sensors.physics.ssr_converter import celsius_of
from teletaction.session.demo_files import calibrated_tables
from teletaction.testbed.rendered_fingers import SESSION, TICK_S

READ_EVERY = 5
"""Ticks from one reading of the thermal sensor to the next, for 100 Hz."""
INDEX = FINGERS.index("index")


class RemoteFingers:
    """Fingers over a scene: the index finger alone, or several.

    Attributes:
        world: world of the fingers.
        drive: last commanded drive of each heater (5,), -1..1.
        plate_c: last reading of the index finger's thermal sensor, C; None before the first.
    """

    def __init__(self, scene: Scene, seed: int, fingers: Sequence[str] = (FINGERS[INDEX],)) -> None:
        """Draw a world of the scene; identification uses the tables calibrated for a scene of this name."""
        materials, surfaces = calibrated_tables(scene.name)
        self.world = RemoteWorld(scene, seed, tuple(fingers))
        self._used = [FINGERS.index(finger) for finger in fingers]
        self._perception = Perception(fingers, MaterialTable.load(materials), SurfaceTable.load(surfaces))
        self.plate_c: float | None = None
        self._heating = Heating(fingers)
        self.drive = np.zeros(len(FINGERS))
        self._ticks = 0

    @property
    def touches(self) -> Mapping[int, FingerIdentification]:
        """Identification of each finger by the remote site."""
        return self._perception.touches

    @property
    def touch(self) -> FingerIdentification:
        """Identification of the index finger by the remote site."""
        return self._perception.touches[INDEX]

    def step(self, x_m: float, z_m: float) -> bytes:
        """Advance by a tick with the hand's set-point at x and the finger's at z, m; return the touch packet."""
        return self.move(x_m, 0.0, np.full(len(FINGERS), z_m)).encode()

    def move(self, x_m: float, y_m: float, z_m: NDArray[np.float64]) -> Touch:
        """Advance by a tick with set-points (x, y) of the hand and z (5,) of the fingers, m; return the touch."""
        self.world.step(TICK_S, x_m, y_m, z_m, self.drive)
        sensed = self._sensed()
        self._perception.step(sensed)
        drives = self._heating.step(sensed, self._perception.touches)
        self.drive = np.array([round(drive * DRIVE_FULL) / DRIVE_FULL for drive in drives])
        self._ticks += 1
        time_ns = round(self.world.time_s * 1e9)
        packet = self._perception.packet(SESSION, self._ticks, time_ns, LinkState.ENGAGED)
        self._perception.work()
        return packet

    def _sensed(self) -> SensorFrame:
        """Return this tick's readings; texture comes in chunks of ten samples, one every 5 ms."""
        world = self.world
        plates: list[PlateReading | None] = [None] * len(FINGERS)
        if self._ticks % READ_EVERY == 0:
            sensor_c, ambient_c = (
                celsius_of(counts).tolist() for counts in (world.ssr_counts(), world.ambient_counts())
            )
            self.plate_c = sensor_c[INDEX]
            for finger in self._used:
                heater_permille = round(DRIVE_FULL * self.drive[finger])
                time_us = round(world.time_s * 1e6)
                plates[finger] = PlateReading(sensor_c[finger], ambient_c[finger], "", time_us, heater_permille)
        counts = world.take_texture_counts()
        texture: list[bytes | None] = [None] * len(FINGERS)
        if counts.size:
            for finger in self._used:
                texture[finger] = counts[finger].astype("<i2").tobytes()
        return SensorFrame(
            world.time_s,
            world.x_m,
            world.y_m,
            tuple(world.z_m.tolist()),
            tuple(world.measured_force_n.tolist()),
            tuple(texture),
            tuple(plates),
            None,
        )
