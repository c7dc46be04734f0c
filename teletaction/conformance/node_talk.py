"""Communicate with one CAN node: frames with the bus's own times, and frames that are deliberately wrong."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import can

from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameSender, frame_crc, packing
from common.buses.serial_port import DeviceAbsent
from teletaction.conformance.checklist import NotApplicable

Values = dict[str, float]
REST_S = 2.0
QUIET_S = 0.25
"""Silence after the last set-point, s, in which time-outs act, forces fall, and a state frame shows it."""
REPEAT_S = 0.01


class NodeName(StrEnum):
    """The two nodes of the page."""

    EXOSKELETON = "exoskeleton"
    TELEMANIPULATOR = "telemanipulator"


@dataclass(frozen=True, slots=True)
class Command:
    """A frame that a node obeys.

    Attributes:
        frame: its name.
        in_force: signal of the state frame that reports it as in force.
    """

    frame: str
    in_force: str


@dataclass(frozen=True, slots=True)
class NodeKind:
    """Frames that one kind of node sends and obeys."""

    name: NodeName
    sends_hz: Mapping[str, float]
    state: str
    safe: Mapping[str, float]
    """Values of the state frame without set-points."""
    commands: Sequence[Command]


EXOSKELETON = NodeKind(
    NodeName.EXOSKELETON,
    {"HandPose": 500.0, "FingerHeights": 500.0, "ExoskeletonState": 100.0},
    "ExoskeletonState",
    {"enabled": 0.0, "thumb": 0.0, "index": 0.0, "middle": 0.0, "ring": 0.0, "little": 0.0},
    (Command("FingerForces", "enabled"),),
)
TELEMANIPULATOR = NodeKind(
    NodeName.TELEMANIPULATOR,
    {"HandPoseMeasured": 500.0, "FingerHeightsMeasured": 500.0, "ContactForces": 500.0, "TelemanipulatorState": 100.0},
    "TelemanipulatorState",
    {"released": 1.0, "hand_alive": 0.0, "heights_alive": 0.0},
    (Command("HandSetpoint", "hand_alive"), Command("HeightSetpoint", "heights_alive")),
)
KINDS = {kind.name: kind for kind in (EXOSKELETON, TELEMANIPULATOR)}


class BusEnd:
    """The host's end of a CAN bus, with the host's clock; the `timestamp` of a frame is the bus's."""

    def __init__(self, address: CanAddress) -> None:
        """Open the bus; raises DeviceAbsent where it cannot be opened."""
        self._bus = address.open()
        self.address = f"CAN {address}"
        self.now = time.monotonic

    def send(self, message: can.Message) -> None:
        """Put a frame on the bus; raises DeviceAbsent where it is gone."""
        try:
            self._bus.send(message)
        except (can.CanError, OSError) as error:
            raise DeviceAbsent(f"{self.address}: {error}") from None

    def receive(self, seconds: float) -> Iterator[can.Message]:
        """Yield the frames of the next `seconds`; raises DeviceAbsent where the bus is gone."""
        until_s = self.now() + seconds
        while (left_s := until_s - self.now()) > 0.0:
            message = self._next(left_s)
            if message is not None:
                yield message

    def waiting(self) -> Iterator[can.Message]:
        """Yield the frames that have arrived and were not read; raises DeviceAbsent where the bus is gone."""
        while (message := self._next(0.0)) is not None:
            yield message

    def _next(self, within_s: float) -> can.Message | None:
        try:
            return self._bus.recv(within_s)
        except (can.CanError, OSError) as error:
            raise DeviceAbsent(f"{self.address}: {error}") from None

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()


def name_of(end: BusEnd) -> NodeName:
    """Return the name of the node on the bus, recognised by its state frames.

    Raises:
        DeviceAbsent: the bus has no node or both.
    """
    heard = {message.arbitration_id for message in end.receive(0.5) if not message.is_error_frame}
    found = [kind.name for kind in KINDS.values() if packing(kind.state).frame_id in heard]
    if len(found) != 1:
        heard_of = " and ".join(found) or "no state frame of a node"
        raise DeviceAbsent(f"{end.address}: open, but {heard_of} heard; --device selects the node to test")
    return found[0]


class NodeTalk:
    """One node on trial.

    Attributes:
        end: the bus.
        kind: kind of the node.
        watch: called with every decoded frame as it arrives; raises Unsafe.
        newest: last values of each frame, even with a wrong CRC.
        commanded: whether a command was sent to it.
        away_s: longest time between two calls of the last `repeat`, s, caused by the host.
    """

    def __init__(self, end: BusEnd, kind: NodeKind) -> None:
        """Check by listening that no other host commands the node, and that it is of the expected kind.

        Raises:
            ValueError: the bus has set-points, because a site is running; or the node is the other one.
        """
        self.end, self.kind = end, kind
        self.watch: Callable[[str, Values], None] = lambda name, values: None
        self.newest: dict[str, Values] = {}
        self.commanded = False
        self.away_s = 0.0
        self._senders = {command.frame: FrameSender(command.frame) for command in kind.commands}
        self._packing = {packing(name).frame_id: (name, packing(name)) for name in kind.sends_hz}
        commanded = {packing(command.frame).frame_id: command.frame for command in kind.commands}
        heard = {message.arbitration_id for message in self.listen(QUIET_S)}
        if foreign := heard & set(commanded):
            raise ValueError(
                f"{end.address}: {commanded[foreign.pop()]} is on the bus: end the site that sends it first"
            )
        there = [other.name for other in KINDS.values() if packing(other.state).frame_id in heard]
        if there and kind.name not in there:
            raise ValueError(f"{end.address}: the {there[0]} is there; expected the {kind.name}")

    @cached_property
    def at_rest(self) -> list[can.Message]:
        """Everything that the node sends without set-points."""
        self._begin_anew()
        return self.listen(REST_S)

    def listen(self, seconds: float) -> list[can.Message]:
        """Return all frames of the next `seconds`; `watch` sees each frame on arrival."""
        return self._read(self.end.receive(seconds))

    def _begin_anew(self) -> None:
        """Discard the frames that arrived while this host was busy or waited for its user."""
        self._read(self.end.waiting())

    def _read(self, frames: Iterator[can.Message]) -> list[can.Message]:
        messages = []
        for message in frames:
            messages.append(message)
            name, layout = self._packing.get(message.arbitration_id, ("", None))
            if layout is not None and len(message.data) == 8 and not message.is_error_frame:
                self.newest[name] = layout.unpack(bytes(message.data))[0]
                self.watch(name, self.newest[name])
        return messages

    def of(self, messages: Sequence[can.Message], name: str) -> list[can.Message]:
        """Return the frames of one name, without error frames."""
        frame_id = packing(name).frame_id
        return [each for each in messages if each.arbitration_id == frame_id and not each.is_error_frame]

    def values(self, messages: Sequence[can.Message], name: str) -> list[tuple[float, Values]]:
        """Return the bus times, s, and the values of the frames of one name."""
        _, layout = self._packing[packing(name).frame_id]
        whole = [each for each in self.of(messages, name) if len(each.data) == 8]
        return [(each.timestamp, layout.unpack(bytes(each.data))[0]) for each in whole]

    def states(self, messages: Sequence[can.Message]) -> list[tuple[float, Values]]:
        """Return the bus times, s, and the values of the state frames."""
        return self.values(messages, self.kind.state)

    def say(self, name: str, values: Values) -> None:
        """Send the next correct frame of a command."""
        self.end.send(self.frame(name, values))

    def frame(self, name: str, values: Values) -> can.Message:
        """Return the next correct frame of a command."""
        self.commanded = True
        return self._senders[name].encode(values)

    def repeat(self, send: Callable[[], None], seconds: float) -> list[can.Message]:
        """Call `send` every 10 ms for `seconds`; return all frames of that time."""
        messages: list[can.Message] = []
        self._begin_anew()
        self.away_s, sent_s = 0.0, self.end.now()
        until_s = sent_s + seconds
        while (now_s := self.end.now()) < until_s:
            self.away_s, sent_s = max(self.away_s, now_s - sent_s), now_s
            send()
            messages += self.listen(REPEAT_S)
        return messages

    def now_at(self, name: str) -> Values:
        """Return the newest values of a frame; raises NotApplicable where no such frame has arrived."""
        if name not in self.newest:
            raise NotApplicable(f"no {name}")
        return self.newest[name]


def settled(states: Sequence[tuple[float, Values]], after_s: float) -> list[Values]:
    """Return the values of the state frames later than `after_s` behind the first, s.

    Raises:
        NotApplicable: there are none.
    """
    late = [values for at_s, values in states if at_s > states[0][0] + after_s]
    if not late:
        raise NotApplicable("no state frame after a change")
    return late


def wrong_crc(message: can.Message) -> can.Message:
    """Return the frame with a wrong CRC."""
    return _with_data(message, bytes(message.data[:7]) + bytes((message.data[7] ^ 0x5A,)))


def crc_of_another(message: can.Message) -> can.Message:
    """Return the frame with the CRC that its bytes would have under another identifier."""
    data = bytes(message.data)
    return _with_data(message, data[:7] + bytes((frame_crc(message.arbitration_id + 1, data),)))


def cut_short(message: can.Message) -> can.Message:
    """Return the frame without its last byte."""
    return _with_data(message, bytes(message.data[:7]))


def _with_data(message: can.Message, data: bytes) -> can.Message:
    return can.Message(arbitration_id=message.arbitration_id, data=data, is_extended_id=False)
