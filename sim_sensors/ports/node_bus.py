"""Connect the simulated CAN nodes of one process with their drivers, with the faults that such a bus can have."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

from common.buses.can_controller import BUS_OFF, RESTARTED
from common.buses.can_frames import SentFrame
from sim_sensors.ports.intruder import Intruder


class Node(Protocol):
    """A CAN node of this process. All its frames have 11-bit identifiers."""

    def feed(self, frame_id: int, data: bytes, now_s: float) -> None:
        """Take a frame from the bus."""

    def take_turn(self) -> list[SentFrame]:
        """Return the frames that the node has to send now."""


class NodeBus(ABC):
    """A CAN bus; subclasses connect the drivers.

    Attributes:
        silent: the nodes are off the bus and neither send nor receive; their own time-outs act.
        deaf: the nodes receive nothing.
        off: the drivers' controller has left the bus, and no frame gets through.
        intruder: a second sender of the drivers' frames, or None.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        self.silent = False
        self.deaf = False
        self.off = False
        self.intruder: Intruder | None = None
        self._nodes = list(nodes)

    @property
    @abstractmethod
    def clients(self) -> int:
        """Number of connected drivers."""

    def pump(self, now_s: float) -> None:
        """Put the nodes' present frames on the bus."""
        if self.silent or self.off:
            return
        for node in self._nodes:
            frames = node.take_turn()
            self._feed(frames, now_s, node)
            self._send(frames, now_s)

    @abstractmethod
    def unplug(self) -> None:
        """Disconnect all drivers and refuse new ones."""

    @abstractmethod
    def plug(self) -> None:
        """Make the bus available again at the same address."""

    def turn_off(self) -> None:
        """Let the drivers' controller leave the bus, as after too many errors, and report this to all drivers."""
        self.off = True
        self._send_error(BUS_OFF)

    def turn_on(self) -> None:
        """Restart the drivers' controller and report this to all drivers."""
        self.off = False
        self._send_error(RESTARTED)

    @abstractmethod
    def close(self) -> None:
        """Disconnect all drivers and release the address."""

    @abstractmethod
    def _send(self, frames: Sequence[SentFrame], now_s: float) -> None:
        """Send frames of 11-bit identifiers to all drivers."""

    @abstractmethod
    def _send_error(self, error: int) -> None:
        """Send an error frame to all drivers."""

    def _received(self, frame_id: int, data: bytes, now_s: float) -> None:
        """Give a driver's frame to the nodes, and then the frames with which an intruder answers it to all."""
        self._feed([(frame_id, data)], now_s)
        if self.intruder is not None:
            foreign = self.intruder.answer(frame_id, data)
            self._feed(foreign, now_s)
            self._send(foreign, now_s)

    def _feed(self, frames: Sequence[SentFrame], now_s: float, sender: Node | None = None) -> None:
        if not (self.silent or self.deaf):
            for node in self._nodes:
                if node is not sender:
                    for frame in frames:
                        node.feed(*frame, now_s)
