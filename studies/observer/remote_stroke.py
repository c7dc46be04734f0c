"""A fingertip that strokes a remote surface, through texture sensor, identification and link to the simulated motor."""

from common.scenes.scene import SceneObject
from common.scenes.surfaces import surface_kind
from sim_sensors.physics.fingertip import pressing_depth_m
from studies.touches.lowering import height_m
from studies.touches.rendered_stroke import DEPTH_M, FingertipCourse, tick_of
from studies.touches.stroke_path import FORCE_N, HOVER_S, LENGTH_M, SECONDS, place_m
from studies.touches.teleoperation import Teleoperation, scene_of
from teletaction.testbed.rendered_fingers import TICK_S


def remote_stroke(surface: str, seed: int) -> FingertipCourse:
    """Tap, rest and stroke as over a virtual surface; the seed determines block, sensors and their noise."""
    depth_m = pressing_depth_m(FORCE_N, surface_kind(surface).stiffness_n_m)
    block = SceneObject(name="block", material="pvc", surface=surface, x_m=0.0, length_m=LENGTH_M)
    both, ticks = Teleoperation(scene_of(block), seed), []
    for tick in range(round(SECONDS / TICK_S)):
        time_s = tick * TICK_S
        hand_m = height_m(time_s - HOVER_S, DEPTH_M)
        both.step(place_m(time_s), height_m(time_s - HOVER_S, depth_m), hand_m)
        ticks.append(tick_of(both.hand, both.remote.touch.mode, -hand_m))
    return FingertipCourse.of(ticks)
