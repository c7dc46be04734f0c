"""Simulates a fingertip on a remote object, from sensors and identification through delayed packets to the TactTip."""

import numpy as np

from common.scenes.materials import material
from sim_sensors.physics.fingertip import pressing_depth_m
from studies.touches.lowering import height_m
from studies.touches.rendered_touch import DEPTH_M, EVERY, REST_S
from studies.touches.simulated_finger import STEP_S, Array
from studies.touches.teleoperation import Teleoperation, block_of, scene_of
from teletaction.testbed.remote_fingers import INDEX
from teletaction.testbed.rendered_fingers import TICK_S

FORCE_N = 1.0
AT_M = 0.03
"""Touched place on the object, m from its near edge."""


def remote_touch(name: str, object_c: float, seconds: float, seed: int) -> Array:
    """Return the change of the felt temperature every STEP_S, K, from when the remote site detects contact.

    The hand waits in the air until sensor and finger are warm, lowers the finger, and holds it there.

    Args:
        name: material or alias; the scene supplies its block and the calibrated table.
        object_c: temperature of the object, C.
        seconds: duration of the touch, s.
        seed: seed of all random draws.
    """
    block = block_of(material(name).name).model_copy(update={"absolute_c": object_c})
    both, remote_m = Teleoperation(scene_of(block), seed), pressing_depth_m(FORCE_N, block.stiffness)
    ticks, before_c, felt = 0, 0.0, list[float]()
    while len(felt) <= round(seconds / STEP_S):
        since_s = ticks * TICK_S - REST_S
        if since_s <= 0.0:
            before_c = float(both.hand.plates.felt_c[INDEX])
        both.step(AT_M, height_m(since_s, remote_m), height_m(since_s, DEPTH_M))
        ticks += 1
        if both.remote.touch.contact and ticks % EVERY == 0:
            felt.append(float(both.hand.plates.felt_c[INDEX]) - before_c)
    return np.array(felt)
