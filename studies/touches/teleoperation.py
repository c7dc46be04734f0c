"""Simulates both sites on virtual time: a remote finger, its delayed touch packets, and the rendered hand."""

from collections import deque

from common.scenes.scene import Scene, SceneObject, load_scene
from common.wire.messages import Touch
from teletaction.testbed.remote_fingers import RemoteFingers
from teletaction.testbed.rendered_fingers import TICK_S, RenderedFingers

SCENE = "materials"
DELAY_S = 0.020
"""Delay of each touch packet, s; the remote finger follows the hand's motion without delay."""


class Teleoperation:
    """One finger that explores an object over a delayed link.

    Attributes:
        remote: the remote finger.
        hand: the operator's hand.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        """Draw both simulated sites from the seed."""
        self.remote, self.hand = RemoteFingers(scene, seed), RenderedFingers(seed)
        self._under_way: deque[bytes | None] = deque([None] * round(DELAY_S / TICK_S))

    def step(self, x_m: float, remote_z_m: float, hand_z_m: float) -> None:
        """Simulate one tick with hand and remote finger at x, m, and at these heights, m."""
        self._under_way.append(self.remote.step(x_m, remote_z_m))
        packet = self._under_way.popleft()
        self.hand.step(None if packet is None else Touch.decode(packet), x_m, hand_z_m)


def scene_of(thing: SceneObject) -> Scene:
    """Return the scene with only this object on the bench."""
    return load_scene(SCENE).model_copy(update={"objects": (thing,), "script": ()})


def block_of(material: str) -> SceneObject:
    """Return the scene's block of a material, given by its full name, placed at x = 0."""
    block = next(thing for thing in load_scene(SCENE).objects if thing.material == material)
    return block.model_copy(update={"x_m": 0.0})
