"""The CAN bus of one site: frames in and out without blocking, re-opened when the gateway was away."""

import logging
from dataclasses import dataclass, field
from typing import Literal

import can
from pydantic import BaseModel, ConfigDict, Field

from common.background import BackgroundOpener
from common.can_frames import BadFrame, FrameReceiver
from common.can_gateway import GatewayBus
from common.serial_line import DeviceAbsent

log = logging.getLogger(__name__)

_MOST_FRAMES = 200
"""Frames read in one poll: a babbling bus must not hold the loop."""


class CanAddress(BaseModel):
    """Where a CAN bus is: `socketcan` for hardware, `socketcand` for a gateway, `virtual` within one process."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    interface: Literal["socketcan", "socketcand", "virtual"]
    channel: str = "can0"
    host: str = "127.0.0.1"
    port: int = Field(default=29536, ge=1, le=65535)

    def __str__(self) -> str:
        return (
            f"{self.interface}://{self.host}:{self.port}/{self.channel}"
            if self.interface == "socketcand"
            else (f"{self.interface}:{self.channel}")
        )

    def open(self) -> can.BusABC:
        """Open the bus; may block for a moment.

        Raises:
            DeviceAbsent: it cannot be opened.
        """
        try:
            if self.interface == "socketcand":
                return GatewayBus(self.channel, self.host, self.port)
            return can.Bus(interface=self.interface, channel=self.channel)
        except (can.CanError, OSError, TimeoutError) as error:
            raise DeviceAbsent(f"CAN {self}: {error}") from None


@dataclass(slots=True)
class CanLine:
    """One bus and the frames that are read from it."""

    address: CanAddress
    receivers: tuple[FrameReceiver, ...]
    times_lost: int = 0
    unknown: int = 0
    unsent: int = 0
    """Frames dropped because the gateway took none."""
    _bus: can.BusABC | None = None
    _opener: BackgroundOpener[can.BusABC] = field(init=False)
    _by_id: dict[int, FrameReceiver] = field(init=False)

    def __post_init__(self) -> None:
        self._by_id = {receiver.frame_id: receiver for receiver in self.receivers}
        self._opener = BackgroundOpener(self.address.open)
        self._opener.discard = _shut_down
        self._opener.start()

    @property
    def connected(self) -> bool:
        """Whether the bus is open."""
        return self._bus is not None

    @property
    def problem(self) -> Exception | None:
        """Why the bus is not open; None while it is, or while it is being tried."""
        return None if self.connected else self._opener.problem

    def figures(self) -> dict[str, object]:
        """What the status file tells of this bus."""
        return {
            "connected": self.connected,
            "times_lost": self.times_lost,
            "refused": {receiver.name: receiver.refused for receiver in self.receivers},
            "unknown": self.unknown,
            "unsent": self.unsent,
        }

    def poll(self) -> dict[str, dict[str, float]]:
        """The newest good values of each frame that came since the last call, by frame name."""
        if self._bus is None:
            self._bus = self._opener.take()
            if self._bus is None:
                return {}
        newest: dict[str, dict[str, float]] = {}
        try:
            for _ in range(_MOST_FRAMES):
                message = self._bus.recv(0)
                if message is None:
                    break
                receiver = self._by_id.get(message.arbitration_id)
                if receiver is None or message.is_error_frame:
                    self.unknown += 1
                    continue
                try:
                    newest[receiver.name] = receiver.decode(bytes(message.data))
                except BadFrame as error:
                    log.debug("%s", error)
        except (can.CanError, OSError) as error:
            self._lose(error)
        return newest

    def send(self, message: can.Message) -> None:
        """Send one frame; with no bus there, nothing happens."""
        if self._bus is None:
            return
        try:
            self._bus.send(message)
        except can.CanTimeoutError:
            self.unsent += 1
        except (can.CanError, OSError) as error:
            self._lose(error)

    def close(self) -> None:
        """Close the bus and stop looking for it."""
        self._opener.stop()
        if self._bus is not None:
            _shut_down(self._bus)
            self._bus = None

    def _lose(self, error: Exception) -> None:
        log.warning("CAN %s lost: %s", self.address, error)
        assert self._bus is not None
        _shut_down(self._bus)
        self._bus = None
        self.times_lost += 1
        self._opener.start()


def _shut_down(bus: can.BusABC) -> None:
    try:
        bus.shutdown()
    except (can.CanError, OSError) as error:
        log.debug("the bus did not shut down cleanly: %s", error)
