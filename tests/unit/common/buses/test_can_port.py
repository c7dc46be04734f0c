"""A CAN line reports its bus: off, on again, and damaged frames. Over python-can's virtual bus."""

import errno
import logging
import socket
import time
from collections.abc import Iterator
from itertools import count

import can
import pytest
from can.interfaces.socketcan import SocketcanBus

from common.buses import can_port
from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameReceiver, FrameSender
from common.buses.can_port import SETTLING, CanPort
from common.buses.encoder_glitches import FINGER_M_S, RETURN_S, EncoderGlitches
from common.buses.frame_error_rate import MOST
from common.buses.socketcand_bus import taken_frame
from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.timing.timeouts import FRAME_S
from tests.waiting import wait_until

names = count()
HEIGHTS = dict.fromkeys(FINGERS, 1.0)
CONTROLLER, BUS_OFF, RESTARTED = 0x004, 0x040, 0x100
RECEIVE_OVERFLOW, ERROR_PASSIVE = 0x01, 0x20
FORCES = (1.0,) * 6


@pytest.fixture
def channel() -> str:
    return f"can-line-{next(names)}"


@pytest.fixture
def device(channel: str) -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel=channel) as bus:
        yield bus


@pytest.fixture
def line(channel: str, device: can.BusABC) -> Iterator[CanPort]:
    address = CanAddress(interface="virtual", channel=channel)
    line = CanPort(address, (FrameReceiver("FingerHeights"),), sends=("FingerForces",))
    wait_until(lambda: (line.poll(), line.connected)[1])
    yield line
    line.close()


def error(kind: int, detail: int = 0) -> can.Message:
    return can.Message(arbitration_id=kind, is_error_frame=True, data=bytes((0, detail, 0, 0, 0, 0, 0, 0)))


def test_bus_off_is_reported_until_the_controller_is_back(device: can.BusABC, line: CanPort) -> None:
    device.send(error(CONTROLLER))
    assert line.poll() == {}
    assert (line.controller.off, line.controller.errors, line.fault, line.unknown) == (False, 1, None, 0)
    device.send(error(BUS_OFF))
    line.poll()
    assert line.fault == Fault(FaultCode.BUS_OFF, detail=str(line.address))
    assert line.figures()["off"] is True
    device.send(error(CONTROLLER, ERROR_PASSIVE))
    line.poll()
    assert line.controller.off
    device.send(error(RESTARTED))
    line.poll()
    assert (line.controller.off, line.fault) == (False, None)
    assert line.figures()["errors"] == 4
    device.send(error(BUS_OFF))
    device.send(FrameSender("FingerHeights").encode(HEIGHTS))
    assert "FingerHeights" in line.poll()
    assert line.fault is None, "a bus that is heard is not off"


def test_errors_of_the_controller_are_in_the_status_and_their_log_is_bounded(
    device: can.BusABC, line: CanPort, caplog: pytest.LogCaptureFixture
) -> None:
    assert (line.figures()["controller"], line.figures()["controller_errors"]) == ("error-active", {})
    for _ in range(1000):
        device.send(error(CONTROLLER, RECEIVE_OVERFLOW | ERROR_PASSIVE))
        line.poll()
    assert line.figures()["controller"] == "error-passive"
    assert line.figures()["controller_errors"] == {"receive overflow": 1000, "error-passive": 1000}
    assert line.fault is None
    assert [record.message for record in caplog.records] == [
        f"CAN {line.address}: controller: receive overflow",
        f"CAN {line.address}: controller: error-passive",
    ]


def test_frames_of_a_gateway_whose_clock_stands_still_are_checked_at_their_rate(
    device: can.BusABC, line: CanPort, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without times, no encoder would be checked: each frame would be the first of another gateway."""
    clock_s = [5.0]
    monkeypatch.setattr(can_port, "taken_frame", lambda message: (clock_s[0], *taken_frame(message)[1:]))
    sender, jumps = FrameSender("FingerHeights"), EncoderGlitches(FINGERS, FINGER_M_S)
    found = []
    for height_mm in (0.0, 0.0, *[8.0] * round(RETURN_S / FRAME_S + 1)):
        device.send(sender.encode(dict.fromkeys(FINGERS, height_mm)))
        for sent_s, heights_mm in line.poll()["FingerHeights"]:
            jumps.step(sent_s, tuple(1e-3 * height for height in heights_mm))
            found += jumps.faults
    assert {fault.code for fault in found} == {FaultCode.ENCODER_JUMPED}
    for clock_s[0], sent_s in ((6.0, 6.0), (6.0, 6.002), (6.0, 6.004), (6.003, 6.006), (6.02, 6.02), (1.0, 1.0)):
        device.send(sender.encode(HEIGHTS))
        assert line.poll()["FingerHeights"][0][0] == pytest.approx(sent_s)


def test_own_frames_from_another_node_are_a_fault_and_no_unknown_ones(device: can.BusABC, line: CanPort) -> None:
    heights, forces = FrameSender("FingerHeights"), FrameSender("FingerForces")
    for _ in range(1000):
        device.send(heights.encode(HEIGHTS))
        line.send(forces.next_frame(FORCES))
        line.poll()
    assert line.fault is None, "what a line sends itself it does not hear"
    device.send(FrameSender("FingerForces").encode(dict.fromkeys((*FINGERS, "enabled"), 1.0)))
    assert line.poll() == {}
    assert line.fault == Fault(FaultCode.FOREIGN_FRAMES, "FingerForces")
    assert (line.figures()["foreign"], line.unknown) == (1, 0)


def test_a_frame_of_29_bits_with_the_number_of_one_of_ours_is_unknown(device: can.BusABC, line: CanPort) -> None:
    heights, forces = FrameSender("FingerHeights"), FrameSender("FingerForces")
    for _ in range(SETTLING):
        device.send(heights.encode(HEIGHTS))
        line.poll()
    for frame_id, data in (heights.named_frame(HEIGHTS), forces.next_frame(FORCES)):
        device.send(can.Message(arbitration_id=frame_id, data=data, is_extended_id=True))
    assert line.unread("FingerHeights") == 0
    assert line.poll() == {}
    assert (line.unknown, line.fault, line.receivers[0].taken) == (2, None, SETTLING)


def test_damaged_frames_are_refused_and_counted_and_many_are_a_fault(device: can.BusABC, line: CanPort) -> None:
    sender = FrameSender("FingerHeights")
    first = sender.encode(HEIGHTS)
    device.send(first)
    assert line.poll()["FingerHeights"][0][1] == pytest.approx((1.0,) * 5)
    for n in range(MOST + 1):
        assert line.fault is None
        device.send(first)
        assert line.poll() == {}
        assert line.receivers[0].refused == n + 1
    assert line.fault == Fault(
        FaultCode.FRAMES_DAMAGED, "FingerHeights", value=MOST + 1, limit=MOST, detail=str(MOST + 2)
    )


def test_lost_frames_are_counted_and_are_no_fault(device: can.BusABC, line: CanPort) -> None:
    sender = FrameSender("FingerHeights")
    for n in range(1, 41):
        frame = sender.encode(HEIGHTS)
        if n % 4 == 0:
            device.send(frame)
            line.poll()
    assert line.figures()["skipped"] == {"FingerHeights": 27}
    assert (line.fault, line.receivers[0].refused) == (None, 0)


def test_all_frames_of_a_poll_are_there_in_their_order_with_the_buss_own_time(
    device: can.BusABC, line: CanPort
) -> None:
    """A place that an encoder jumped to counts, although the newest frame has it back."""
    sender, before_s = FrameSender("FingerHeights"), time.time()
    for index_mm in (1.0, 6.0, 1.0):
        device.send(sender.encode(HEIGHTS | {"index": index_mm}))
    assert [values[1] for _, values in line.poll()["FingerHeights"]] == pytest.approx([1.0, 6.0, 1.0])
    assert [values[1] for _, values in line.came["FingerHeights"]] == pytest.approx([1.0, 6.0, 1.0])
    assert all(before_s <= sent_s <= time.time() for sent_s, _ in line.came["FingerHeights"])
    line.poll()
    assert line.came == {}


class BrokenBus:
    """A bus whose sends fail."""

    def __init__(self, failure: Exception) -> None:
        self.failure = failure

    def fileno(self) -> int:
        raise NotImplementedError

    def recv(self, timeout: float) -> None:
        return None

    def send(self, message: can.Message) -> None:
        raise self.failure

    def shutdown(self) -> None:
        """Nothing is held open."""


def broken(line: CanPort, monkeypatch: pytest.MonkeyPatch, failure: Exception) -> CanPort:
    """The line on a bus whose sends fail."""
    line.close()
    monkeypatch.setattr(line, "_bus", BrokenBus(failure))
    return line


@pytest.mark.parametrize("code", [errno.ENETDOWN, errno.ENODEV, errno.EBADF, None])
def test_a_bus_with_failing_sends_is_lost_with_the_reason(
    line: CanPort, monkeypatch: pytest.MonkeyPatch, code: int | None
) -> None:
    assert line.problem is None
    failure = can.CanOperationError("Failed to transmit: Network is down", code)
    broken(line, monkeypatch, failure).send(FrameSender("FingerForces").next_frame(FORCES))
    assert (line.connected, line.times_lost, line.unsent, line.fault) == (False, 1, 0, None)
    assert str(line.problem) == f"CAN {line.address} lost: {failure}"


@pytest.mark.parametrize(
    "failure",
    [
        can.CanOperationError("Failed to transmit: No buffer space available", errno.ENOBUFS),
        can.CanOperationError("Failed to transmit: Resource temporarily unavailable", errno.EAGAIN),
        can.CanOperationError("Transmit buffer full"),
        can.CanTimeoutError("the gateway takes nothing"),
        OSError(errno.ENOBUFS, "No buffer space available"),
        BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable"),
    ],
    ids=str,
)
def test_a_full_transmit_queue_is_no_lost_bus_and_its_log_is_bounded(
    line: CanPort, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, failure: Exception
) -> None:
    broken(line, monkeypatch, failure)
    for n in range(2500):
        line.send(FrameSender("FingerForces").next_frame(FORCES))
        assert (line.connected, line.times_lost, line.unsent) == (True, 0, n + 1)
    assert line.figures()["unsent"] == 2500
    assert caplog.record_tuples == [
        ("common.buses.can_port", logging.WARNING, f"CAN {line.address}: transmit queue full, 1 frames not sent")
    ]


def test_a_blocked_socket_in_python_can_counts_as_a_full_queue(line: CanPort, monkeypatch: pytest.MonkeyPatch) -> None:
    near, far = socket.socketpair()
    with near, far:
        near.setblocking(False)
        try:
            while True:
                near.send(bytes(4096))
        except BlockingIOError:
            pass
        bus = SocketcanBus.__new__(SocketcanBus)
        bus.socket, bus.channel = near, "can0"
        monkeypatch.setattr(SocketcanBus, "shutdown", lambda bus: None)
        line.close()
        monkeypatch.setattr(line, "_bus", bus)
        line.send(FrameSender("FingerForces").next_frame(FORCES))
        assert (line.connected, line.unsent) == (True, 1)
        monkeypatch.setattr(line, "_bus", None)
        bus._is_shutdown = True


def test_a_bus_lost_at_once_is_opened_again_after_growing_pauses(
    channel: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(CanAddress, "open", lambda _: BrokenBus(can.CanOperationError("down", errno.ENETDOWN)))
    line = CanPort(CanAddress(interface="virtual", channel=channel), ())
    end_s = time.monotonic() + 0.6
    while time.monotonic() < end_s:
        line.poll()
        line.send(FrameSender("FingerForces").next_frame(FORCES))
    line.close()
    assert 1 <= line.times_lost <= 2
    assert len(caplog.records) == line.times_lost
