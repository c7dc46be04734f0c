"""Reads and writes the CAN bus of one site without blocking, and re-opens it when it was lost."""

import errno
import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import can

from common.buses.can_address import CanAddress
from common.buses.can_controller import CanController
from common.buses.can_frames import BadFrame, FrameReceiver, SentFrame, packing
from common.buses.frame_error_rate import FrameErrorRate
from common.buses.serial_port import DeviceAbsent
from common.buses.socketcand_bus import GatewayBus, TakenFrame, taken_frame
from common.buses.wiring import SYSTEM, Opener, Wiring
from common.faults.fault import Fault, FaultCode
from common.link.rate_limiter import RateLimiters

log = logging.getLogger(__name__)

_LINES_PER_S = 0.1
"""Maximum rate of log lines about one kind of error, 1/s."""
_MOST_FRAMES = 200
"""Maximum number of frames read in one poll: a babbling bus must not hold the loop."""
_FULL_CODES = (errno.ENOBUFS, errno.EAGAIN)
"""Error codes of a socket that takes no data now."""
_FULL_WORDS = "Transmit buffer full"
"""Message that python-can raises without a code for a socket that takes no data now."""

SETTLING = 500
"""Frames of a new connection that count for nothing: an earlier connection may have left them. They take 0.4 s."""
CLEAR_AFTER = 1000
"""Number of frames without one of this host's own after which the fault of a second sender ends."""


class DuplicateSender:
    """Finds a second sender of this host's frames, which devices would obey: a bus returns no frame to its sender.

    Attributes:
        heard: own frames that came after a connection had settled, in all connections.
    """

    def __init__(self, names: Sequence[str]) -> None:
        """`names`: the frames that this host sends."""
        self.heard = 0
        self._names = {packing(name).frame_id: name for name in names}
        self.begin()

    def begin(self) -> None:
        """Start a new connection."""
        self._seen = 0
        self._last: tuple[int, str] | None = None

    def step(self, frame_id: int) -> bool:
        """Take one frame; return whether it has an identifier that only this host may send."""
        self._seen += 1
        if frame_id not in self._names:
            return False
        if self._seen > SETTLING:
            self.heard += 1
            self._last = self._seen, self._names[frame_id]
        return True

    @property
    def fault(self) -> Fault | None:
        """The second sender's fault; None without a second sender."""
        if self._last is None or self._seen - self._last[0] > CLEAR_AFTER:
            return None
        return Fault(FaultCode.FOREIGN_FRAMES, self._last[1])


@dataclass(slots=True)
class CanPort:
    """One bus and the frames that are read from it."""

    address: CanAddress
    receivers: tuple[FrameReceiver, ...]
    sends: tuple[str, ...] = ()
    """Names of the frames that this host alone may send."""
    wiring: Wiring = SYSTEM
    times_lost: int = 0
    unknown: int = 0
    unsent: int = 0
    """Frames dropped because the gateway or the transmit queue took none."""
    controller: CanController = field(default_factory=CanController)
    came: dict[str, list[tuple[float, tuple[float, ...]]]] = field(default_factory=dict)
    """Good frames of the last poll by name, oldest first: time on the bus's clock, s, and values in the order of their
    bits."""
    readable: bool | None = None
    """See `ReadyLines`."""
    descriptor: int | None = None
    drained: bool = True
    """Whether the last poll has read all that waited."""
    _bus: can.BusABC | None = None
    _unread: list[TakenFrame] = field(default_factory=list)
    """Frames taken from the bus for the next poll."""
    _opener: Opener[can.BusABC] = field(init=False)
    _by_id: dict[int, tuple[FrameReceiver, FrameErrorRate]] = field(init=False)
    _own: DuplicateSender = field(init=False)
    _lost: DeviceAbsent | None = None
    _lines: RateLimiters[str] = field(default_factory=lambda: RateLimiters(_LINES_PER_S, 1))

    def __post_init__(self) -> None:
        self._own = DuplicateSender(self.sends)
        self._forget()
        self._opener = self.wiring.opener(lambda: self.wiring.open_bus(self.address), _shut_down)
        self._opener.start()

    @property
    def connected(self) -> bool:
        """Whether the bus is open."""
        return self._bus is not None

    @property
    def problem(self) -> Exception | None:
        """Reason why the bus is not open; None while it is open or the first attempt is under way."""
        return None if self.connected else self._opener.problem or self._lost

    @property
    def fault(self) -> Fault | None:
        """The fault of the open bus; None without one."""
        if self._bus is None:
            return None
        if self.controller.off:
            return Fault(FaultCode.BUS_OFF, detail=str(self.address))
        if self._own.fault:
            return self._own.fault
        for _, damage in self._by_id.values():
            if damage.fault:
                return damage.fault
        return None

    def figures(self) -> dict[str, object]:
        """Return the figures of this bus for the status file."""
        return {
            "connected": self.connected,
            "times_lost": self.times_lost,
            "off": self.controller.off,
            "controller": self.controller.state,
            "controller_errors": dict(self.controller.counts),
            "foreign": self._own.heard,
            "refused": {receiver.name: receiver.refused for receiver in self.receivers},
            "skipped": {receiver.name: receiver.skipped for receiver in self.receivers},
            "unknown": self.unknown,
            "errors": self.controller.errors,
            "unsent": self.unsent,
        }

    def poll(self) -> dict[str, list[tuple[float, tuple[float, ...]]]]:
        """Read the frames that arrived since the last call; return `came`."""
        self.came = {}
        if self._bus is None:
            self._bus = self._opener.take()
            if self._bus is None:
                return self.came
            self.descriptor, self.readable = _descriptor(self._bus), None
            self._forget()
        self.drained = True
        if self.readable is False and not self._unread:
            return self.came
        try:
            all_taken = self._gather(self._bus)
            frames, self._unread = self._unread[:_MOST_FRAMES], self._unread[_MOST_FRAMES:]
            self._take(frames)
            self.drained = all_taken and not self._unread
        except (can.CanError, OSError) as error:
            self._lose(error)
        return self.came

    def unread(self, name: str) -> int:
        """Return how many frames of this name the next poll will read."""
        if self._bus is None or (self.readable is False and not self._unread):
            return 0
        try:
            self._gather(self._bus)
        except (can.CanError, OSError) as error:
            self._lose(error)
        frame_id = next(receiver.frame_id for receiver in self.receivers if receiver.name == name)
        return sum(
            unread_id == frame_id and not (extended or is_error) for _, unread_id, _, extended, is_error in self._unread
        )

    def _gather(self, bus: can.BusABC) -> bool:
        """Take frames from the bus, about as many as one poll reads; return whether the bus has no more."""
        unread = self._unread
        while len(unread) < _MOST_FRAMES:
            if isinstance(bus, GatewayBus):
                found, more = bus.take_some()
                unread.extend(found)
            else:
                message = bus.recv(0)
                more = message is not None
                if message is not None:
                    unread.append(taken_frame(message))
            if not more:
                return True
        return False

    def send(self, *frames: SentFrame) -> None:
        """Send frames; does nothing while the bus is not open."""
        bus, sent = self._bus, 0
        if bus is None:
            return
        try:
            if isinstance(bus, GatewayBus):
                bus.send_all(frames)
            else:
                for frame_id, data in frames:
                    bus.send(can.Message(arbitration_id=frame_id, data=data, is_extended_id=False))
                    sent += 1
        except (can.CanError, OSError) as error:
            if not _queue_is_full(error):
                self._lose(error)
                return
            self.unsent += len(frames) - sent
            if self._lines.allows("full", time.monotonic()):
                log.warning("CAN %s: transmit queue full, %d frames not sent", self.address, self.unsent)

    def close(self) -> None:
        """Close the bus and stop opening it."""
        self._opener.stop()
        if self._bus is not None:
            _shut_down(self._bus)
            self._bus = self.descriptor = None

    def _take(self, frames: Sequence[TakenFrame]) -> None:
        """Check frames and put the good ones into `came`."""
        by_id, own, controller, came = self._by_id, self._own, self.controller, self.came
        for read_s, frame_id, data, extended, is_error in frames:
            if is_error:
                self._report(frame_id, data)
            elif extended:  # another node's, whatever its number is
                self.unknown += 1
            elif own.step(frame_id):
                continue
            elif (watched := by_id.get(frame_id)) is None:
                self.unknown += 1
            else:
                receiver, damage = watched
                sent_s = receiver.sent_s(read_s)
                try:
                    values = receiver.values(data)
                except BadFrame as error:
                    log.debug("%s", error)
                    damage.step(sent_s, damaged=True)
                    continue
                damage.step(sent_s, damaged=False)
                if controller.off:
                    controller.alive()
                came.setdefault(receiver.name, []).append((sent_s, values))

    def _report(self, error: int, data: bytes) -> None:
        """Take an error frame's class and bytes."""
        for name in self.controller.report(error, data):
            if self._lines.allows(name, time.monotonic()):
                log.warning("CAN %s: controller: %s", self.address, name)

    def _forget(self) -> None:
        """Reset counters and error rates for a new connection; a bus that was off remains so until a frame arrives."""
        self._unread.clear()
        self._own.begin()
        for receiver in self.receivers:
            receiver.begin()
        self._by_id = {receiver.frame_id: (receiver, FrameErrorRate(receiver.name)) for receiver in self.receivers}

    def _lose(self, error: Exception) -> None:
        log.warning("CAN %s lost: %s", self.address, error)
        self._lost = DeviceAbsent(f"CAN {self.address} lost: {error}")
        assert self._bus is not None
        _shut_down(self._bus)
        self._bus = self.descriptor = None
        self.times_lost += 1
        self._opener.start()


def _queue_is_full(error: Exception) -> bool:
    """Return whether a frame was not sent because the transmit queue of an open bus was full."""
    if isinstance(error, can.CanTimeoutError):
        return True
    if isinstance(error, can.CanError):
        return error.error_code in _FULL_CODES or str(error) == _FULL_WORDS
    return getattr(error, "errno", None) in _FULL_CODES


def _descriptor(bus: can.BusABC) -> int | None:
    """Return the file descriptor of a bus; None for a bus within one process."""
    try:
        return bus.fileno()
    except NotImplementedError:
        return None


def _shut_down(bus: can.BusABC) -> None:
    try:
        bus.shutdown()
    except (can.CanError, OSError) as error:
        log.debug("the bus did not shut down cleanly: %s", error)
