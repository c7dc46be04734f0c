"""What trials command a node with: values that move nothing, and neutral ones."""

from typing import Protocol

from common.fingers import FINGERS
from teletaction.conformance.checklist import Unsafe
from teletaction.conformance.node_talk import EXOSKELETON, QUIET_S, NodeTalk, Values

FORCE_N, MOST_N = 0.3, 1.0
"""Trials push with so much; a node that applies more than the second, or a finger that meets it, ends them."""
LOWEST_MM = -10.24
MOST_MM = 5.0
"""A telemanipulator that goes further than this from where it stood ends the trials."""


class NodeOnTrial(Protocol):
    """A node and how it is commanded."""

    talk: NodeTalk

    def acting(self, frame: str) -> Values:
        """Values of a command that is in force, and as good as harmless."""

    def neutral(self) -> None:
        """Say that nothing is wanted."""

    def settle(self) -> None:
        """Neutral, and silence until the time-outs have acted."""


class ExoskeletonOnTrial:
    """An exoskeleton that nobody wears."""

    def __init__(self, talk: NodeTalk) -> None:
        self.talk = talk
        talk.watch = self._look

    def acting(self, frame: str) -> Values:
        """A small push on every finger."""
        return {"enabled": 1.0, **dict.fromkeys(FINGERS, FORCE_N)}

    def neutral(self) -> None:
        """Not enabled, no force; said twice: one frame may be lost."""
        for _ in range(2):
            self.talk.say("FingerForces", {"enabled": 0.0, **dict.fromkeys(FINGERS, 0.0)})

    def settle(self) -> None:
        """Neutral, and silence until the forces have fallen."""
        self.neutral()
        self.talk.listen(QUIET_S)

    def _look(self, name: str, values: Values) -> None:
        if name == EXOSKELETON.state and max(values[finger] for finger in FINGERS) > MOST_N:
            raise Unsafe(f"it pushes with {max(values[finger] for finger in FINGERS):.2f} N")


class TelemanipulatorOnTrial:
    """A telemanipulator with nothing under its fingers.

    Attributes:
        lowered: fingers at the top have been lowered once, to have room above them.
    """

    def __init__(self, talk: NodeTalk) -> None:
        self.talk = talk
        self.lowered = False
        self._stood: dict[str, Values] = {}
        self._holds: dict[str, Values] = {}
        talk.watch = self._look

    def acting(self, frame: str) -> Values:
        """To where it stood when it was last at rest: one that sags under its set-point must not be lowered by it."""
        if frame == "HandSetpoint":
            return self._hold("HandPoseMeasured")
        return {"released": 0.0, **self._hold("FingerHeightsMeasured")}

    def neutral(self) -> None:
        """Released where it stands; said twice: one frame may be lost."""
        heights = self.talk.newest.get("FingerHeightsMeasured", dict.fromkeys(FINGERS, LOWEST_MM))
        for _ in range(2):
            self.talk.say("HeightSetpoint", {**heights, "released": 1.0})

    def settle(self) -> None:
        """Released, and silence until the time-outs have acted."""
        self.neutral()
        self.talk.listen(QUIET_S)
        self._holds.clear()

    def _hold(self, name: str) -> Values:
        return self._holds.setdefault(name, dict(self.talk.now_at(name)))

    def _look(self, name: str, values: Values) -> None:
        if name == "ContactForces" and self.talk.commanded and max(values.values()) > MOST_N:
            raise Unsafe(f"a finger meets something with {max(values.values()):.2f} N")
        if name not in ("HandPoseMeasured", "FingerHeightsMeasured"):
            return
        stood = self._stood.setdefault(name, values)
        furthest_mm = max(abs(values[each] - stood[each]) for each in stood)
        if furthest_mm > MOST_MM:
            raise Unsafe(f"it is {furthest_mm:.1f} mm from where it stood")
