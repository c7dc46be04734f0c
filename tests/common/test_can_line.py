"""What a CAN line says of its bus: off, on again, and what comes over it damaged. Over python-can's virtual bus."""

import time
from collections.abc import Iterator
from itertools import count

import can
import pytest

from common.can_frames import FrameReceiver, FrameSender
from common.can_line import BUS_OFF, RESTARTED, CanAddress, CanLine
from common.fingers import FINGERS
from common.frame_damage import MOST

names = count()
HEIGHTS = dict.fromkeys(FINGERS, 1.0)
ERROR_PASSIVE = 0x004


@pytest.fixture
def channel() -> str:
    return f"can-line-{next(names)}"


@pytest.fixture
def device(channel: str) -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel=channel) as bus:
        yield bus


@pytest.fixture
def line(channel: str, device: can.BusABC) -> Iterator[CanLine]:
    line = CanLine(CanAddress(interface="virtual", channel=channel), (FrameReceiver("FingerHeights"),))
    deadline = time.monotonic() + 5.0
    while not line.connected:
        assert time.monotonic() < deadline
        line.poll()
    yield line
    line.close()


def error(kind: int) -> can.Message:
    return can.Message(arbitration_id=kind, is_error_frame=True)


def test_a_controller_that_left_the_bus_is_named_until_it_is_on_it_again(device: can.BusABC, line: CanLine) -> None:
    device.send(error(ERROR_PASSIVE))
    assert line.poll() == {}
    assert (line.off, line.errors, line.fault, line.unknown) == (False, 1, "", 0)
    device.send(error(BUS_OFF | ERROR_PASSIVE))
    line.poll()
    assert line.fault == f"CAN bus is off: the controller of {line.address} has left it after too many errors"
    assert line.figures()["off"] is True
    device.send(error(ERROR_PASSIVE))
    line.poll()
    assert line.off
    device.send(error(RESTARTED))
    line.poll()
    assert (line.off, line.fault, line.errors) == (False, "", 4)


def test_a_bus_that_is_heard_is_not_off(device: can.BusABC, line: CanLine) -> None:
    device.send(error(BUS_OFF))
    device.send(FrameSender("FingerHeights").encode(HEIGHTS))
    assert "FingerHeights" in line.poll()
    assert line.fault == ""


def test_damage_is_refused_counted_and_named_when_there_is_too_much_of_it(device: can.BusABC, line: CanLine) -> None:
    sender = FrameSender("FingerHeights")
    first = sender.encode(HEIGHTS)
    device.send(first)
    assert line.poll()["FingerHeights"] == pytest.approx(HEIGHTS)
    for n in range(MOST + 1):
        assert line.fault == ""
        device.send(first)
        assert line.poll() == {}
        assert line.receivers[0].refused == n + 1
    assert line.fault == f"{MOST + 1} of the last {MOST + 2} FingerHeights frames damaged"


def test_frames_that_were_lost_are_counted_and_are_no_fault(device: can.BusABC, line: CanLine) -> None:
    sender = FrameSender("FingerHeights")
    for n in range(1, 41):
        frame = sender.encode(HEIGHTS)
        if n % 4 == 0:
            device.send(frame)
            line.poll()
    assert line.figures()["skipped"] == {"FingerHeights": 27}
    assert (line.fault, line.receivers[0].refused) == ("", 0)


def test_a_good_frames_time_is_the_buss_own(device: can.BusABC, line: CanLine) -> None:
    frame = FrameSender("FingerHeights").encode(HEIGHTS)
    before_s = time.time()
    device.send(frame)
    line.poll()
    assert before_s <= line.sent_s["FingerHeights"] <= time.time()


class BrokenBus:
    """A bus whose sends fail."""

    def recv(self, timeout: float) -> None:
        return None

    def send(self, message: can.Message) -> None:
        raise can.CanOperationError("Failed to transmit: [Errno 105] No buffer space available")

    def shutdown(self) -> None:
        """Nothing is held open."""


def test_a_bus_whose_sends_fail_is_lost_and_says_why(line: CanLine, monkeypatch: pytest.MonkeyPatch) -> None:
    assert line.problem is None
    line.close()
    monkeypatch.setattr(line, "_bus", BrokenBus())
    line.send(FrameSender("FingerForces").encode({**HEIGHTS, "enabled": 1.0}))
    assert (line.connected, line.times_lost, line.fault) == (False, 1, "")
    assert str(line.problem) == f"CAN {line.address} lost: Failed to transmit: [Errno 105] No buffer space available"
