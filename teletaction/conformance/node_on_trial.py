"""Command a node in trials: with values that move nothing, and with neutral values."""

from abc import ABC, abstractmethod

import can

from common.fingers import FINGERS
from teletaction.conformance.checklist import Unsafe
from teletaction.conformance.node_talk import EXOSKELETON, QUIET_S, NodeTalk, Values

FORCE_N, MOST_N = 0.3, 1.0
"""Force of the trials, and largest force, N; a node that applies more, or a finger that meets more, ends the trials."""
LOWEST_MM = -10.24
MOST_MM = 5.0
"""Largest distance of a telemanipulator from its first position, mm; a larger one ends the trials."""


class NodeOnTrial(ABC):
    """A node with its commands for trials."""

    def __init__(self, talk: NodeTalk) -> None:
        self.talk = talk
        talk.watch = self._look

    @abstractmethod
    def acting(self, frame: str) -> Values:
        """Return the values of a command that is in force and practically harmless."""

    def settle(self, longer_s: float = 0.0) -> None:
        """Command neutral outputs, then send nothing until the time-outs have acted, and for `longer_s` more.

        Raises:
            Unsafe: a frame that came earlier comes no longer.
        """
        expected = set(self.talk.newest)
        for _ in range(2):  # one frame may be lost
            self.talk.say(*self._neutral())
        messages = self.talk.listen(QUIET_S + longer_s)
        if self._missing(expected, messages):  # this host may have paused instead
            messages += self.talk.listen(QUIET_S)
        if missing := self._missing(expected, messages):
            raise Unsafe(f"no more {', '.join(missing)}")

    def _missing(self, expected: set[str], messages: list[can.Message]) -> list[str]:
        return sorted(name for name in expected if not self.talk.of(messages, name))

    @abstractmethod
    def _neutral(self) -> tuple[str, Values]:
        """Return name and values of a command with neutral outputs."""

    @abstractmethod
    def _look(self, name: str, values: Values) -> None:
        """Check a frame on arrival; raise Unsafe for a value beyond its limit."""


class ExoskeletonOnTrial(NodeOnTrial):
    """An exoskeleton that nobody wears."""

    def acting(self, frame: str) -> Values:
        """Return a small force on every finger."""
        return {"enabled": 1.0, **dict.fromkeys(FINGERS, FORCE_N)}

    def _neutral(self) -> tuple[str, Values]:
        return "FingerForces", dict(EXOSKELETON.safe)

    def _look(self, name: str, values: Values) -> None:
        if name == EXOSKELETON.state and max(values[finger] for finger in FINGERS) > MOST_N:
            raise Unsafe(f"it pushes with {max(values[finger] for finger in FINGERS):.2f} N")


class TelemanipulatorOnTrial(NodeOnTrial):
    """A telemanipulator with nothing under its fingers.

    Attributes:
        lowered: whether fingers at the top were lowered once, to have room above them.
    """

    def __init__(self, talk: NodeTalk) -> None:
        super().__init__(talk)
        self.lowered = False
        self._stood: dict[str, Values] = {}
        self._holds: dict[str, Values] = {}

    def acting(self, frame: str) -> Values:
        """Return the position of the last rest; a hand that sags under its set-point must not be lowered by it."""
        if frame == "HandSetpoint":
            return self._hold("HandPoseMeasured")
        return {"released": 0.0, **self._hold("FingerHeightsMeasured")}

    def settle(self, longer_s: float = 0.0) -> None:
        """Settle; a later command holds the position of this rest."""
        super().settle(longer_s)
        self._holds.clear()

    def _neutral(self) -> tuple[str, Values]:
        heights = self.talk.newest.get("FingerHeightsMeasured", dict.fromkeys(FINGERS, LOWEST_MM))
        return "HeightSetpoint", {**heights, "released": 1.0}

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
