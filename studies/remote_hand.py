"""One simulated remote finger, and what the remote site makes of it as packets, on virtual time."""

import numpy as np

from common.fingers import FINGERS
from common.packets import LinkState
from common.scene import Scene
from common.serial_messages import DRIVE_FULL
from remote_site.finger_touch import FingerTouch
from remote_site.material_table import MaterialTable
from remote_site.perception import Perception
from remote_site.sensed import Sensed
from remote_site.surface_class import SurfaceTable
from remote_site.thermal_sensor import PlateReading
from sim_sensors.remote_world import RemoteWorld
from sim_sensors.ssr_converter import celsius_of
from studies.rendered_hand import SESSION, TICK_S
from teletaction.demo_files import calibrated_tables

READ_EVERY = 5
"""Ticks between two readings of the thermal sensor: 100 Hz."""
INDEX = FINGERS.index("index")


class RemoteHand:
    """The index finger over a scene.

    Attributes:
        world: where it is.
        plate_c: last reading of the thermal sensor, C; None before the first.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        """Draw a world of the scene; it is identified with the tables calibrated for a scene of its name."""
        materials, surfaces = calibrated_tables(scene.name)
        self.world = RemoteWorld(scene, seed, (FINGERS[INDEX],))
        self._perception = Perception((FINGERS[INDEX],), MaterialTable.load(materials), SurfaceTable.load(surfaces))
        self.plate_c: float | None = None
        self._drive = np.zeros(len(FINGERS))
        self._ticks = 0

    @property
    def touch(self) -> FingerTouch:
        """What the finger feels now, as the remote site has it."""
        return self._perception.touches[INDEX]

    def step(self, x_m: float, z_m: float) -> bytes:
        """Let a tick pass with the hand told to be at x and the finger at z; returns the touch packet."""
        self.world.step(TICK_S, x_m, 0.0, np.full(len(FINGERS), z_m), self._drive)
        self._perception.step(self._sensed())
        self._drive[INDEX] = round(self.touch.heater_drive * DRIVE_FULL) / DRIVE_FULL
        self._ticks += 1
        time_ns = round(self.world.time_s * 1e9)
        return self._perception.packet(SESSION, self._ticks, time_ns, LinkState.ENGAGED).encode()

    def _sensed(self) -> Sensed:
        """This tick's readings; texture comes in chunks of ten samples, which is what 5 ms bring."""
        world = self.world
        plates: list[PlateReading | None] = [None] * len(FINGERS)
        if self._ticks % READ_EVERY == 0:
            sensor_c, ambient_c = (
                float(celsius_of(counts)[INDEX]) for counts in (world.ssr_counts(), world.ambient_counts())
            )
            self.plate_c = sensor_c
            heater_permille = round(DRIVE_FULL * self._drive[INDEX])
            plates[INDEX] = PlateReading(sensor_c, ambient_c, "", round(world.time_s * 1e6), heater_permille)
        counts = world.take_texture_counts()[INDEX]
        texture: list[bytes | None] = [None] * len(FINGERS)
        if counts.size:
            texture[INDEX] = counts.astype("<i2").tobytes()
        return Sensed(
            world.time_s,
            world.x_m,
            world.y_m,
            tuple(world.z_m.tolist()),
            tuple(world.measured_force_n.tolist()),
            tuple(texture),
            tuple(plates),
        )
