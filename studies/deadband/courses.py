"""Motions for the study of deadbands: recorded hands at a handle, and the scripted hand over the scene."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.scenes.scene import load_scene
from sim_sensors.operator_hand.hand import ScriptedHand
from studies.running import data_files
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
    return [
        Course(path.stem, RECORDED_HZ, (LEVER_M * _columns(path)[1]).astype(np.float32)[:, None, None] * _ALONG_X)
        for path in data_files(RECORDINGS)
    ]


def recorded_forces_n() -> list[NDArray[np.float64]]:
    """Magnitude of the environment's force on each recorded follower, at the end of its lever, N."""
    return [np.abs(_columns(path)[4]) / LEVER_M for path in data_files(RECORDINGS)]


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


def _columns(path: Path) -> NDArray[np.float64]:
    """time_s, leader_rad, follower_rad, hand_torque_nm, environment_torque_nm of a recording, (5, samples)."""
    return np.loadtxt(path, delimiter=",", skiprows=1).T
