"""Base class of the simulated CAN nodes: frames in with their time of arrival, frames out, set-points that expire."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from common.buses.can_frames import BadFrame, FrameReceiver, FrameSender, SentFrame
from common.limits import MODULE_TIMEOUT_S
from sim_sensors.devices.breakable_parts import Transmitter

STATE_EVERY = 5
"""Turns from one state report to the next: a node that measures at 500 Hz reports at 100 Hz, to limit the bus load."""


class CanNode(ABC):
    """Base of the emulated CAN nodes, independent of bus, clock and physics.

    Attributes:
        refused: number of damaged or repeated frames.
        transmitter: output stage of all its frames, which can be broken.
    """

    def __init__(self, receivers: tuple[FrameReceiver, ...], state: FrameSender) -> None:
        self._receivers = {receiver.frame_id: receiver for receiver in receivers}
        self._heard_s: dict[str, float] = {}
        self.transmitter = Transmitter()
        self._state = state
        self._turns = 0

    @property
    def refused(self) -> int:
        """Number of frames addressed to this node that it refused."""
        return sum(receiver.refused for receiver in self._receivers.values())

    def feed(self, frame_id: int, data: bytes, now_s: float) -> None:
        """Take a frame from the bus and act on it; damaged frames and frames for other nodes are ignored."""
        receiver = self._receivers.get(frame_id)
        if receiver is None:
            return
        try:
            values = receiver.values(data)
        except BadFrame:
            return
        self._heard_s[receiver.name] = now_s
        self._obey(receiver.name, values, now_s)

    def silent_s(self, name: str, now_s: float) -> float:
        """Return the time since the last good frame of that name, s; infinite before the first."""
        return now_s - self._heard_s.get(name, -float("inf"))

    def alive(self, name: str, now_s: float) -> bool:
        """Return whether that frame's set-point is still valid, received less than `MODULE_TIMEOUT_S` ago."""
        return self.silent_s(name, now_s) < MODULE_TIMEOUT_S

    def take_turn(self) -> list[SentFrame]:
        """Return the frames of the next turn: the measurements, and in every fifth turn also the applied outputs."""
        frames = self._measured()
        if self._turns % STATE_EVERY == 0:
            frames.append(self._state.next_frame(self._applied()))
        self._turns += 1
        return self.transmitter.send(frames)

    @abstractmethod
    def _obey(self, name: str, values: Sequence[float], now_s: float) -> None:
        """Act on a good frame with these values, in the order of their bits."""

    @abstractmethod
    def _measured(self) -> list[SentFrame]:
        """Return frames with the present measurements."""

    @abstractmethod
    def _applied(self) -> Sequence[float]:
        """Return the present outputs as the values of the state frame, in the order of their bits."""
