"""Simulate serial lines and CAN buses in memory: both ends of each, with the faults of `sim_sensors.faults.faults`."""

from collections import deque
from collections.abc import Callable, Sequence

import can
import serial

from common.buses.can_frames import SentFrame
from common.buses.serial_port import CHUNK, DeviceAbsent
from sim_sensors.ports.node_bus import Node, NodeBus
from sim_sensors.ports.serial_server import Device, SerialServer

_BACKLOG_BYTES = 16 * 1024
_BACKLOG_FRAMES = 1000


class Cable:
    """Common part of a line and a bus.

    Attributes:
        plugged: whether the cable is plugged; otherwise, open ports fail and no port can be opened.
        pulled: how often it was pulled; a port that was open then stays dead.
    """

    plugged = True
    pulled = 0

    def unplug(self) -> None:
        """Pull the cable."""
        self.plugged = False
        self.pulled += 1

    def plug(self) -> None:
        """Put the cable back."""
        self.plugged = True

    def close(self) -> None:
        """Pull the cable for good."""
        self.plugged = False


class MemoryLine(Cable, SerialServer):
    """A simulated module's end of a serial line.

    Attributes:
        address: address that a driver opens.
        unread: bytes of the module that the driver has not read.
    """

    def __init__(self, device: Device, now_s: Callable[[], float], address: str) -> None:
        """Serve a module; `now_s` is virtual time, s."""
        super().__init__(device)
        self.address = address
        self.unread = bytearray()
        self._now_s = now_s
        self._held: bytearray | None = None

    @property
    def hears(self) -> bool:
        """Whether a driver's bytes reach the module."""
        return self.plugged and not (self.silent or self.deaf)

    def take(self, data: bytes) -> None:
        """Take bytes that the driver writes now."""
        if self._held is None:
            self._received(data, self._now_s())
        else:
            self._held += data

    def hold(self) -> None:
        """Stop the module's process; bytes of drivers wait."""
        self._held = bytearray()

    def release(self) -> None:
        """Resume the process, which reads the waiting data."""
        held, self._held = self._held, None
        if held:
            self.take(bytes(held))

    def send(self, output: bytes) -> None:
        """Keep bytes until the driver reads them; the oldest are dropped."""
        self.unread += output
        if len(self.unread) > _BACKLOG_BYTES:
            del self.unread[:-_BACKLOG_BYTES]


class MemoryPort:
    """A driver's end of a serial line; see `common.buses.serial_port.Port`."""

    descriptor: int | None = None

    def __init__(self, line: MemoryLine) -> None:
        """Open the port; the first bytes are those that the module sends from now on.

        Raises:
            DeviceAbsent: the cable is unplugged.
        """
        if not line.plugged:
            raise DeviceAbsent(f"{line.address}: unplugged")
        self._line, self._pulled = line, line.pulled
        line.unread.clear()

    def wait(self, seconds: float) -> bool:
        """As `Port.wait`; raise SerialException instead of waiting, because no bytes can arrive meanwhile."""
        self._check()
        if not self._line.unread and seconds > 0.0:
            raise serial.SerialException("the device sends nothing")
        return bool(self._line.unread)

    def read(self) -> bytes:
        """As `Port.read`."""
        self._check()
        chunk = bytes(self._line.unread[:CHUNK])
        del self._line.unread[:CHUNK]
        return chunk

    def write(self, data: bytes) -> int:
        """As `Port.write`."""
        self._check()
        self._line.take(data)
        return len(data)

    def unread(self) -> int:
        """As `Port.unread`."""
        return len(self._line.unread)

    def close(self) -> None:
        """As `Port.close`; there is nothing to close."""

    def _check(self) -> None:
        if not self._line.plugged or self._line.pulled != self._pulled:
            raise serial.SerialException("unplugged")


class MemoryBus(Cable, NodeBus):
    """A CAN bus with the simulated nodes of one site.

    Attributes:
        connections: connected drivers.
    """

    def __init__(self, now_s: Callable[[], float], nodes: Sequence[Node]) -> None:
        """Serve nodes; `now_s` is virtual time, s."""
        super().__init__(nodes)
        self.connections: list[MemoryCan] = []
        self._now_s = now_s
        self._held: list[SentFrame] | None = None

    @property
    def hears(self) -> bool:
        """Whether a driver's frames reach the nodes."""
        return self.plugged and not (self.silent or self.deaf or self.off)

    @property
    def clients(self) -> int:
        """Number of connected drivers."""
        return len(self.connections)

    def take(self, frame_id: int, data: bytes) -> None:
        """Deliver a driver's frame to the nodes."""
        if self._held is not None:
            self._held.append((frame_id, data))
        elif self.plugged and not self.off:
            self._received(frame_id, data, self._now_s())

    def unplug(self) -> None:
        """As `Cable.unplug`; all drivers are disconnected."""
        super().unplug()
        self.connections.clear()

    def hold(self) -> None:
        """Stop the nodes' process; frames of drivers wait."""
        self._held = []

    def release(self) -> None:
        """Resume the process, which reads the waiting data."""
        held, self._held = self._held or [], None
        for frame_id, data in held:
            self.take(frame_id, data)

    def _send(self, frames: Sequence[SentFrame], now_s: float) -> None:
        if not self.connections:
            return
        messages = [
            can.Message(timestamp=now_s, arbitration_id=frame_id, data=data, is_extended_id=False)
            for frame_id, data in frames
        ]
        for connection in self.connections:
            connection.unread.extend(messages)

    def _send_error(self, error: int) -> None:
        for connection in self.connections:
            connection.unread.append(can.Message(arbitration_id=error, is_error_frame=True))


class MemoryCan(can.BusABC):
    """A driver's connection to a bus."""

    def __init__(self, bus: MemoryBus) -> None:
        """Connect; raises DeviceAbsent where the bus is gone."""
        if not bus.plugged:
            raise DeviceAbsent("the bus is gone")
        super().__init__("memory")
        self.unread: deque[can.Message] = deque(maxlen=_BACKLOG_FRAMES)
        self._bus, self._pulled = bus, bus.pulled
        bus.connections.append(self)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame, or None; raise CanOperationError if the bus is gone."""
        self._check()
        return self.unread.popleft() if self.unread else None

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Put a frame on the bus; raise CanOperationError if the bus is gone."""
        self._check()
        self._bus.take(msg.arbitration_id, bytes(msg.data))

    def shutdown(self) -> None:
        """Disconnect."""
        super().shutdown()
        if self in self._bus.connections:
            self._bus.connections.remove(self)

    def _check(self) -> None:
        if not self._bus.plugged or self._bus.pulled != self._pulled:
            raise can.CanOperationError("the bus is gone")
