"""Both sites on virtual time: a remote finger, its touch packets and their delay, and the rendered hand."""

from collections import deque

from common.messages import Touch
from common.scene import Scene, SceneObject, load_scene
from teletaction.testbed.remote_fingers import RemoteFingers
from teletaction.testbed.rendered_fingers import TICK_S, RenderedFingers

SCENE = "materials"
DELAY_S = 0.020
"""Of each touch packet; the hand's motion is followed at once."""


class Teleoperation:
    """One finger explores an object, and feels it.

    Attributes:
        remote: the remote finger.
        hand: the operator's hand.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        """Draw both worlds."""
        self.remote, self.hand = RemoteFingers(scene, seed), RenderedFingers(seed)
        self._under_way: deque[bytes | None] = deque([None] * round(DELAY_S / TICK_S))

    def step(self, x_m: float, remote_z_m: float, hand_z_m: float) -> None:
        """Let a tick pass with hand and remote finger at x, and at these heights."""
        self._under_way.append(self.remote.step(x_m, remote_z_m))
        packet = self._under_way.popleft()
        self.hand.step(None if packet is None else Touch.decode(packet), x_m, hand_z_m)


def scene_of(thing: SceneObject) -> Scene:
    """The scene with nothing else on the bench."""
    return load_scene(SCENE).model_copy(update={"objects": (thing,), "script": ()})


def block_of(material: str) -> SceneObject:
    """The scene's block of a material (its proper name), at the place where x is 0."""
    block = next(thing for thing in load_scene(SCENE).objects if thing.material == material)
    return block.model_copy(update={"x_m": 0.0})
