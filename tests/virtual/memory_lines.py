"""Serial lines and CAN buses in memory: both ends of each, with the faults of `sim_sensors.faults`."""

from collections import deque
from collections.abc import Sequence

import can
import serial

from common.can_controller import BUS_OFF, RESTARTED
from sim_sensors.intruder import Intruder
from sim_sensors.select_loop import SelectLoop
from sim_sensors.serial_server import Device, SerialServer
from sim_sensors.socketcand import Node

_BACKLOG_BYTES = 16 * 1024
_BACKLOG_FRAMES = 1000


class MemoryLine(SerialServer):
    """An emulated module's end of a serial line.

    Attributes:
        plugged: whether the cable is in; without, ports at this line fail and none can be opened.
    """

    def __init__(self, device: Device, loop: SelectLoop, address: str) -> None:
        super().__init__(device, loop)
        self.address = address
        self.plugged = True
        self.unread = bytearray()

    @property
    def hears(self) -> bool:
        """Whether what a driver sends reaches the module."""
        return self.plugged and not (self.silent or self.deaf)

    def unplug(self) -> None:
        """Pull the cable."""
        self.plugged = False

    def plug(self) -> None:
        """Put the cable back."""
        self.plugged = True

    def close(self) -> None:
        """Hang up."""
        self.plugged = False

    def take(self, data: bytes) -> None:
        """Take bytes that the driver has written now."""
        self._received(data, self._loop.now())

    def _send(self, output: bytes) -> None:
        self.unread += output
        if len(self.unread) > _BACKLOG_BYTES:
            del self.unread[:-_BACKLOG_BYTES]


class MemoryPort:
    """A driver's end of a serial line, with what drivers use of pyserial's ports."""

    timeout: float = 0.05
    write_timeout: float = 0.5

    def __init__(self, line: MemoryLine, descriptor: int) -> None:
        self._line = line
        self._descriptor = descriptor

    def open(self) -> None:
        """Begin with what the module says from now on; raises SerialException when the cable is out."""
        self._check()
        self._line.unread.clear()

    def fileno(self) -> int:
        """A descriptor that can always be written to, for `select`."""
        return self._descriptor

    @property
    def in_waiting(self) -> int:
        """How many bytes came and wait."""
        return len(self._line.unread)

    def read(self, most: int) -> bytes:
        """What came, at once.

        Raises:
            SerialException: the cable is out, or a read that may wait would find nothing: nobody comes while it waits.
        """
        self._check()
        unread = self._line.unread
        if not unread and self.timeout > 0.0:
            raise serial.SerialException("the device says nothing")
        chunk = bytes(unread[:most])
        del unread[:most]
        return chunk

    def write(self, data: bytes) -> int:
        """Hand bytes to the module; raises SerialException when the cable is out."""
        self._check()
        self._line.take(data)
        return len(data)

    def close(self) -> None:
        """Nothing is held open."""

    def _check(self) -> None:
        if not self._line.plugged:
            raise serial.SerialException("unplugged")


class MemoryBus:
    """A CAN bus with the emulated nodes of one site; takes the place of the socketcand gateway and its faults.

    Attributes:
        plugged: whether the gateway is there; without, open connections fail and none can be opened.
        silent: whether the nodes neither say nor hear anything.
        deaf: whether they hear nothing.
        off: whether the gateway's controller has left the bus.
        connections: drivers that are connected.
        intruder: a second sender of the drivers' frames.
    """

    def __init__(self, loop: SelectLoop, nodes: Sequence[Node]) -> None:
        self.plugged = True
        self.silent = False
        self.deaf = False
        self.off = False
        self.connections: list[MemoryCan] = []
        self.intruder: Intruder | None = None
        self._loop = loop
        self._nodes = nodes

    @property
    def hears(self) -> bool:
        """Whether what a driver sends reaches the nodes."""
        return self.plugged and not (self.silent or self.deaf or self.off)

    @property
    def clients(self) -> int:
        """How many drivers are connected."""
        return len(self.connections)

    def pump(self, now_s: float) -> None:
        """Hand what the nodes have to send now to the drivers."""
        if not (self.silent or self.off):
            for node in self._nodes:
                frames = node.take_frames()
                for frame in frames:
                    frame.timestamp = now_s
                for connection in self.connections:
                    connection.unread.extend(frames)

    def take(self, message: can.Message) -> None:
        """Hand a driver's frame to the nodes."""
        if not self.hears:
            return
        now_s = self._loop.now()
        data = bytes(message.data)
        for node in self._nodes:
            node.feed(message.arbitration_id, data, now_s)
        for foreign in () if self.intruder is None else self.intruder.answer(message.arbitration_id, data):
            foreign.timestamp = now_s
            for node in self._nodes:
                node.feed(foreign.arbitration_id, bytes(foreign.data), now_s)
            for connection in self.connections:
                connection.unread.append(foreign)

    def turn_off(self) -> None:
        """Let the gateway's controller leave the bus."""
        self.off = True
        self._tell_error(BUS_OFF)

    def turn_on(self) -> None:
        """Start it again."""
        self.off = False
        self._tell_error(RESTARTED)

    def _tell_error(self, error: int) -> None:
        for connection in self.connections:
            connection.unread.append(can.Message(arbitration_id=error, is_error_frame=True))

    def unplug(self) -> None:
        """Take the gateway away."""
        self.plugged = False

    def plug(self) -> None:
        """Bring it back."""
        self.plugged = True

    def close(self) -> None:
        """The gateway is gone."""
        self.plugged = False


class MemoryCan:
    """A driver's connection to a bus, with what drivers use of python-can's buses."""

    def __init__(self, bus: MemoryBus) -> None:
        self.unread: deque[can.Message] = deque(maxlen=_BACKLOG_FRAMES)
        self._bus = bus
        bus.connections.append(self)

    def fileno(self) -> int:
        """There is none."""
        raise NotImplementedError

    def recv(self, timeout: float) -> can.Message | None:
        """The next frame; raises CanOperationError when the gateway is gone."""
        self._check()
        return self.unread.popleft() if self.unread else None

    def send(self, message: can.Message) -> None:
        """Put a frame on the bus; raises CanOperationError when the gateway is gone."""
        self._check()
        self._bus.take(message)

    def shutdown(self) -> None:
        """Disconnect."""
        self._bus.connections.remove(self)

    def _check(self) -> None:
        if not self._bus.plugged:
            raise can.CanOperationError("the gateway is gone")
