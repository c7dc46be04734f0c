"""Motions for the study of deadbands: recorded hands at a handle, and the scripted hand over the scene."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.scenes.scene import load_scene
from sim_sensors.operator_hand.hand import ScriptedHand
from studies.running import data_files, recorded_columns
from studies.teleoperation_stability.recorded import LEVER_M
from studies.touches.teleoperation import SCENE

Places = NDArray[np.float32]

RECORDINGS, RECORDED_HZ = "bilateral_1dof", 1000.0
_ALONG_X = np.array([1.0, 0.0, 0.0], np.float32)


class Course(NamedTuple):
    """One hand's places at every tick, (ticks, fingers, directions), m."""

    name: str
    rate_hz: float
    place_m: Places

    def thinned(self, rate_hz: float) -> "Course":
        """The same hand sampled at a lower rate."""
        return Course(self.name, rate_hz, self.place_m[:: round(self.rate_hz / rate_hz)])


def recorded() -> list[Course]:
    """Place of every recorded leader at the end of its lever; empty where there are no recordings."""
    leaders_rad = {path.stem: recorded_columns(path, "leader_rad")[0] for path in data_files(RECORDINGS)}
    return [
        Course(name, RECORDED_HZ, (LEVER_M * leader_rad).astype(np.float32)[:, None, None] * _ALONG_X)
        for name, leader_rad in leaders_rad.items()
    ]


def recorded_forces_n() -> list[NDArray[np.float64]]:
    """Magnitude of the environment's force on each recorded follower, at the end of its lever, N."""
    torques_nm = [recorded_columns(path, "environment_torque_nm")[0] for path in data_files(RECORDINGS)]
    return [np.abs(torque_nm) / LEVER_M for torque_nm in torques_nm]


def scripted(rate_hz: float, seconds: float, seed: int) -> Course:
    """Five fingers at work on the scene, with tremor and drift but no reaction forces; rounded as on the bus."""
    hand = ScriptedHand(load_scene(SCENE), seed=seed)
    hand.start()
    places = []
    for _ in range(round(seconds * rate_hz)):
        hand.step(1.0 / rate_hz, np.zeros(5))
        x_m, y_m = (2e-5 * round(place / 2e-5) for place in (hand.x_m, hand.y_m))
        places.append([(x_m, y_m, 5e-6 * round(z_m / 5e-6)) for z_m in hand.z_m.tolist()])
    return Course(SCENE, rate_hz, np.array(places, dtype=np.float32))
