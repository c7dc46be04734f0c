"""Opens one serial device on a tty or a `socket://` address, identifies it, reads it, and re-opens it when lost."""

import logging
import threading
import time
from dataclasses import dataclass, field

from common.buses.serial_messages import DeviceKind, FrameReader, Identity, MessageId, Report, encode_frame
from common.buses.serial_port import BAUD, CHUNK, DeviceAbsent, Port
from common.buses.wiring import SYSTEM, Opener, Wiring
from common.fingers import FINGERS

log = logging.getLogger(__name__)

_IDENTIFY_S = 1.0
_PATIENCE_S = 0.05


class WrongDevice(ValueError):
    """The device at an address is not the one that the configuration names."""


def device_name(kind: DeviceKind, finger: str) -> str:
    """Return the name of a device, such as `index tacttip`, or `patient_switch`, which belongs to no finger."""
    name = kind.name.lower()
    return name if kind is DeviceKind.PATIENT_SWITCH else f"{finger} {name}"


def plain_name(kind: DeviceKind, finger: str) -> str:
    """Return the same for people: `index tacttip`, `patient switch`."""
    return device_name(kind, finger).replace("_", " ")


@dataclass(frozen=True, slots=True)
class OpenLine:
    """An open port whose device has answered with its identity."""

    port: Port
    identity: Identity


def open_line(address: str, wiring: Wiring = SYSTEM) -> OpenLine:
    """Open an address and ask the device for its identity; blocks up to about a second.

    Raises:
        DeviceAbsent: there is no device, or it does not answer.
    """
    port = wiring.open_port(address)
    reader = FrameReader()
    try:
        deadline = time.monotonic() + _IDENTIFY_S
        port.write(encode_frame(MessageId.IDENTIFY, 0))
        while time.monotonic() < deadline:
            if not port.wait(_PATIENCE_S):
                continue
            for frame in reader.feed(port.read()):
                if frame.message_id == MessageId.IDENTITY:
                    return OpenLine(port, Identity.decode(frame.payload))
    except (OSError, ValueError) as error:
        port.close()
        raise DeviceAbsent(f"{address}: {error}") from None
    port.close()
    garbage = f"; the received bytes are no frames: is it at {BAUD} baud?" if reader.damaged else ""
    raise DeviceAbsent(f"{address}: a port, but no device answers IDENTIFY within {_IDENTIFY_S:g} s{garbage}")


def _discard(opened: OpenLine) -> None:
    _hang_up(opened.port)


def _hang_up(port: Port) -> None:
    """Close in a thread: the library sleeps 0.3 s after closing a socket, and a tty may wait for its output."""
    threading.Thread(target=port.close, daemon=True, name="closer").start()


@dataclass(slots=True)
class SerialDevice:
    """The serial line to one device. Reading and writing never block.

    Attributes:
        finger: finger of the device; for a device without one, FINGERS[0].
    """

    address: str
    kind: DeviceKind
    finger: str
    wiring: Wiring = SYSTEM
    identity: Identity | None = None
    """Identity of the connected device; None while none is connected."""
    reader: FrameReader = field(default_factory=FrameReader)
    times_lost: int = 0
    unsent: int = 0
    """Messages dropped because the line was full."""
    readable: bool | None = None
    """See `ReadyLines`."""
    descriptor: int | None = None
    drained: bool = True
    """Whether the last poll has read all waiting data."""
    _port: Port | None = None
    _sequence: int = 0
    _opener: Opener[OpenLine] = field(init=False)

    def __post_init__(self) -> None:
        self._opener = self.wiring.opener(self._open_checked, _discard)
        self._opener.start()

    @property
    def name(self) -> str:
        """Name of the device for logs and status files."""
        return device_name(self.kind, self.finger)

    @property
    def connected(self) -> bool:
        """Whether the right device is connected."""
        return self._port is not None

    @property
    def problem(self) -> Exception | None:
        """Reason why no device is connected: DeviceAbsent or WrongDevice; None while connected or being identified."""
        return None if self.connected else self._opener.problem

    def figures(self) -> dict[str, object]:
        """Return the figures of this line for the status file."""
        return {
            "serial": self.identity.serial if self.identity is not None else None,
            "times_lost": self.times_lost,
            "damaged": self.reader.damaged,
            "missed": self.reader.lost,
            "repeated": self.reader.repeated,
            "malformed": self.reader.malformed,
            "unsent": self.unsent,
        }

    def poll(self, kind: type[Report]) -> list[Report]:
        """Return the reports that arrived since the last call; take over a device that was opened."""
        if self._port is None:
            opened = self._opener.take()
            if opened is None:
                return []
            self._port, self.identity = opened.port, opened.identity
            self.descriptor, self.readable = opened.port.descriptor, None
            self.reader = FrameReader()
            log.info("%s: serial number %s", self.name, opened.identity.serial)
        try:
            waits = self._port.wait(0.0) if self.readable is None else self.readable
            chunk = self._port.read() if waits else b""
        except OSError as error:
            self._lose(error)
            return []
        self.drained = len(chunk) < CHUNK
        return self.reader.reports(chunk, kind) if chunk else []

    def unread_bytes(self) -> int:
        """Return how many bytes wait to be read; 0 while no device is connected."""
        if self._port is None or self.readable is False:
            return 0
        try:
            return self._port.unread()
        except OSError:
            return 0  # the next poll detects the loss

    def send(self, message_id: MessageId, payload: bytes) -> None:
        """Send one message; it is dropped while no device is connected or the line takes no data."""
        if self._port is None:
            return
        self._sequence = (self._sequence + 1) & 0xFF
        try:
            frame = encode_frame(message_id, self._sequence, payload)
            if self._port.write(frame) < len(frame):
                self.unsent += 1
        except OSError as error:
            self._lose(error)

    def close(self) -> None:
        """Close the port and stop looking for the device."""
        self._opener.stop()
        if self._port is not None:
            _hang_up(self._port)
            self._port = self.descriptor = None

    def _open_checked(self) -> OpenLine:
        opened = open_line(self.address, self.wiring)
        found = opened.identity
        owner = FINGERS[found.finger]
        if found.kind is not self.kind or owner != self.finger:
            opened.port.close()
            is_, says = (device_name(*one) for one in ((found.kind, f"{owner}'s"), (self.kind, f"{self.finger}'s")))
            raise WrongDevice(f"{self.address}: is the {is_} {found.serial}, the configuration says {says}")
        return opened

    def _lose(self, error: Exception) -> None:
        log.warning("%s at %s lost: %s", self.name, self.address, error)
        assert self._port is not None
        _hang_up(self._port)
        self._port = self.descriptor = self.identity = None
        self.times_lost += 1
        self._opener.start()
