"""What every simulated CAN node does: frames in with their time of arrival, frames out, set-points that expire."""

from abc import ABC, abstractmethod

import can

from common.can_frames import BadFrame, FrameReceiver, FrameSender, SentFrame
from common.limits import MODULE_TIMEOUT_S
from sim_sensors.faulty_parts import Transmitter

STATE_EVERY = 5
"""Turns between two reports of what the node does: 100 Hz where it measures at 500 Hz, for the sake of the bus."""


class CanNode(ABC):
    """Base of the emulated CAN nodes. It knows no bus, no clock and no physics.

    Attributes:
        refused: frames that were damaged or repeated.
        transmitter: what its frames go through.
    """

    def __init__(self, receivers: tuple[FrameReceiver, ...], state: FrameSender) -> None:
        self._receivers = {receiver.frame_id: receiver for receiver in receivers}
        self._heard_s: dict[str, float] = {}
        self.transmitter = Transmitter()
        self._state = state
        self._turns = 0

    @property
    def refused(self) -> int:
        """Frames addressed to this node that it did not act on."""
        return sum(receiver.refused for receiver in self._receivers.values())

    def feed(self, frame_id: int, data: bytes, now_s: float) -> None:
        """Take a frame from the bus; frames for others are let pass."""
        receiver = self._receivers.get(frame_id)
        if receiver is None:
            return
        try:
            values = receiver.decode(data)
        except BadFrame:
            return
        self._heard_s[receiver.name] = now_s
        self._obey(receiver.name, values, now_s)

    def silent_s(self, name: str, now_s: float) -> float:
        """How long ago the last good frame of that name came, s; infinite if none ever did."""
        return now_s - self._heard_s.get(name, -float("inf"))

    def alive(self, name: str, now_s: float) -> bool:
        """Whether that frame's set-point is still in force."""
        return self.silent_s(name, now_s) < MODULE_TIMEOUT_S

    def take_turn(self) -> list[SentFrame]:
        """The frames of the next turn: what is measured now, and in every fifth what the node does."""
        frames = self._measured()
        if self._turns % STATE_EVERY == 0:
            frames.append(self._state.named_frame(self._applied()))
        self._turns += 1
        return self.transmitter.send(frames)

    def take_frames(self) -> list[can.Message]:
        """The same as messages of python-can."""
        return [
            can.Message(arbitration_id=number, data=data, is_extended_id=False) for number, data in self.take_turn()
        ]

    @abstractmethod
    def _obey(self, name: str, values: dict[str, float], now_s: float) -> None:
        """Act on a good frame."""

    @abstractmethod
    def _measured(self) -> list[SentFrame]:
        """Frames with what the node measures now."""

    @abstractmethod
    def _applied(self) -> dict[str, float]:
        """What the node's outputs do now, as the values of its state frame."""
