"""The connection to a CAN gateway against gateways that behave badly."""

import os
import select
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, suppress

import can
import pytest

import common.buses.socketcand_bus
from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameReceiver, FrameSender
from common.buses.can_port import CanPort
from common.buses.serial_port import DeviceAbsent
from common.buses.socketcand_bus import GatewayBus, TakenFrame
from common.buses.tcp_options import DEAD_S
from tests.descriptors import many_open_files
from tests.waiting import wait_until

HELLO = (b"< hi >", b"< ok >", b"< ok >")
FRAME = can.Message(arbitration_id=0x123, data=b"\x01", is_extended_id=False)


class Gateway:
    """Says its words one for one to every client that speaks, then leaves the connections to the test."""

    def __init__(self, words: tuple[bytes, ...]) -> None:
        self.words = words
        self.connections: list[socket.socket] = []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self.listener.getsockname()[1]
        self.thread = threading.Thread(target=self._serve)
        self.thread.start()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                connection, _ = self.listener.accept()
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                self.connections.append(connection)
                connection.sendall(self.words[0])
                for word in self.words[1:]:
                    if not connection.recv(100):
                        break
                    connection.sendall(word)

    def close(self) -> None:
        with suppress(OSError):
            self.listener.shutdown(socket.SHUT_RDWR)
        while self.thread.is_alive():  # it may just be taking one more client
            for connection in self.connections:
                with suppress(OSError):
                    connection.shutdown(socket.SHUT_RDWR)
            self.thread.join(0.01)
        for connection in [self.listener, *self.connections]:
            connection.close()


@pytest.fixture
def stage() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def gateway(stage: ExitStack, *words: bytes) -> Gateway:
    found = Gateway(words)
    stage.callback(found.close)
    return found


@pytest.fixture
def there(stage: ExitStack) -> Gateway:
    return gateway(stage, *HELLO)


@pytest.fixture
def bus(there: Gateway) -> Iterator[GatewayBus]:
    bus = GatewayBus("can0", "127.0.0.1", there.port)
    yield bus
    bus.shutdown()


def test_the_end_of_a_gateway_is_noticed_by_listening_alone(there: Gateway, bus: GatewayBus) -> None:
    assert bus.recv(0.0) is None
    there.connections[-1].sendall(b"< frame 012 1.5 ff000a >< error 040 2.500000 >< fra")
    there.connections[-1].shutdown(socket.SHUT_RDWR)
    heard = bus.recv(2.0)
    assert heard is not None
    assert (heard.arbitration_id, bytes(heard.data), heard.is_error_frame) == (0x12, b"\xff\x00\x0a", False)
    error = bus.recv(2.0)
    assert error is not None
    assert (error.arbitration_id, error.is_error_frame) == (0x40, True)
    with pytest.raises(can.CanOperationError, match="hung up"):
        bus.recv(2.0)


def test_a_gateway_is_reached_while_many_files_are_open(there: Gateway) -> None:
    with many_open_files():
        bus = GatewayBus("can0", "127.0.0.1", there.port)
        there.connections[-1].sendall(b"< frame 123 1.0 01 >")
        try:
            frame = bus.recv(5.0)
        finally:
            bus.shutdown()
    assert frame is not None
    assert frame.arbitration_id == 0x123


def test_a_gateway_that_stops_reading_blocks_nobody(bus: GatewayBus) -> None:
    taken = 0
    try:
        while taken < 1_000_000:
            bus.send(FRAME)
            taken += 1
    except can.CanTimeoutError:
        pass
    assert 0 < taken < 1_000_000
    with pytest.raises(can.CanTimeoutError):
        bus.send(FRAME)


def test_a_partly_sent_frame_is_finished_before_the_next(there: Gateway, bus: GatewayBus) -> None:
    frame, heard = b"< send 123 1 01 >", bytearray()
    with socket.socket(fileno=os.dup(bus.fileno())) as same_connection:
        same_connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    bus.send_all([(0x123, b"\x01")] * 4000)
    with pytest.raises(can.CanTimeoutError):
        bus.send(FRAME)

    def sent() -> bool:
        with suppress(BlockingIOError):
            heard.extend(there.connections[-1].recv(1 << 16, socket.MSG_DONTWAIT))
        with suppress(can.CanTimeoutError):
            bus.send(FRAME)
            return True
        return False

    wait_until(sent)
    there.connections[-1].settimeout(2.0)
    while len(heard) < 4001 * len(frame):
        heard += there.connections[-1].recv(1 << 16)
    assert heard == 4001 * frame


def test_a_frame_without_a_sent_byte_is_dropped(bus: GatewayBus) -> None:
    with socket.socket(fileno=os.dup(bus.fileno())) as same_connection:
        with suppress(BlockingIOError):
            while True:
                same_connection.send(bytes(4096), socket.MSG_DONTWAIT)
        with pytest.raises(can.CanTimeoutError):
            bus.send(FRAME)


def test_frames_are_written_whole_and_in_one_piece(there: Gateway, bus: GatewayBus) -> None:
    bus.send_all([(0x123, b"\x01"), (0x12, b"\x00\xff\x0a")])
    there.connections[-1].settimeout(2.0)
    assert there.connections[-1].recv(1000) == b"< send 123 1 01 >< send 012 3 00 ff 0a >"
    bus.send(can.Message(arbitration_id=0x1ABCDEF, data=b"\x00\xff\x0a"))
    assert there.connections[-1].recv(1000) == b"< send 01ABCDEF 3 00 ff 0a >"


def test_all_frames_that_have_come_are_taken_at_once_and_half_ones_wait(there: Gateway, bus: GatewayBus) -> None:
    assert bus.take_some() == ([], False)
    there.connections[-1].sendall(b"< frame 012 1.5 ff000a >< frame 00000345 2.5  >< frame 013 2")
    found: list[TakenFrame] = []
    wait_until(lambda: found.extend(bus.take_some()[0]) or len(found) >= 2)
    assert found == [(1.5, 0x12, b"\xff\x00\x0a", False, False), (2.5, 0x345, b"", True, False)]
    there.connections[-1].sendall(b".0 01 >< error 040 2.500000 >")
    wait_until(lambda: found.extend(bus.take_some()[0]) or len(found) >= 4)
    assert found[2] == (2.0, 0x13, b"\x01", False, False)
    assert (found[3][1], found[3][4]) == (0x40, True), "an error frame is marked as one"


@pytest.mark.parametrize(
    ("words", "frames"),
    [
        (b"< frame 210 1.5 00 >< frame 00000345 2.5 0aFF >", [(1.5, 0x210, b"\x00"), (2.5, 0x345, b"\x0a\xff")]),
        (b"< frame 210 1.5 00 >\n< ok >< frame 211 2 0a >", [(1.5, 0x210, b"\x00"), (2.0, 0x211, b"\x0a")]),
        (b"6 00 >< frame 210 1.5 00 >", [(1.5, 0x210, b"\x00")]),
        (b"< frame 210 1.5 00 >< frame", [(1.5, 0x210, b"\x00")]),
        (b"< frame 1210 1.5 00 >", [(1.5, 0x1210, b"\x00")]),
    ],
)
def test_frames_are_read_among_other_words(
    words: bytes, frames: list[tuple[float, int, bytes]], there: Gateway, bus: GatewayBus
) -> None:
    there.connections[-1].sendall(words)
    assert select.select((bus,), (), (), 2.0)[0]
    assert [found[:3] for found in bus.take_some()[0]] == frames


@pytest.mark.parametrize(
    "words",
    [
        *(b"< frame xyz 1.5 00 >", b"< frame 012 soon 00 >", b"< frame 012 1.5 0g >", b"\xff"),
        *(b"< frame 012 nan 00 >", b"< frame 012 1e999 00 >", b"< frame 012 %s.0 00 >" % (b"9" * 400)),
        *(b"< frame 012 nan 00 00 >", b"< frame 012 >", b"< frame 012 1.5 >", b"< error 040 >"),
    ],
)
def test_a_wrong_frame_ends_the_connection_with_its_reason(words: bytes, there: Gateway, bus: GatewayBus) -> None:
    there.connections[-1].sendall(words)
    with pytest.raises(can.CanError, match="invalid frame"):
        bus.recv(2.0)


def test_a_line_counts_frames_not_taken_by_a_stalled_gateway_and_continues(there: Gateway, stage: ExitStack) -> None:
    line = CanPort(CanAddress(interface="socketcand", port=there.port), (FrameReceiver("HandPose"),))
    stage.callback(line.close)
    wait_until(lambda: (line.poll(), line.connected)[1])
    sender = FrameSender("HandPose")
    wait_until(lambda: line.send(sender.next_frame((0.0, 0.0))) or line.unsent >= 10, every_s=0.0)
    assert (line.connected, line.times_lost, line.unsent) == (True, 0, 10)
    assert line.figures()["unsent"] == 10
    there.connections[-1].sendall(b"< frame 012 1.5 ff000a >")
    wait_until(lambda: (line.poll(), line.unknown)[1])
    assert line.unknown == 1


@pytest.mark.parametrize("words", [(b"",), HELLO[:1], HELLO[:2]])
def test_an_unresponsive_gateway_is_given_up(
    words: tuple[bytes, ...], stage: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(common.buses.socketcand_bus, "ANSWER_S", 0.05)
    there = gateway(stage, *words)
    with pytest.raises((can.CanTimeoutError, TimeoutError)):
        GatewayBus("can0", "127.0.0.1", there.port)


@pytest.mark.parametrize(
    "words", [(b"SSH-2.0-Open\r\n",), (b"< hi >\xff",), (b"< hi >", b"< error could not open bus >")]
)
def test_a_wrong_gateway_or_a_missing_bus_is_absent_by_name(words: tuple[bytes, ...], stage: ExitStack) -> None:
    there = gateway(stage, *words)
    with pytest.raises(DeviceAbsent, match=f"CAN socketcand://127.0.0.1:{there.port}/can0: "):
        CanAddress(interface="socketcand", port=there.port).open()


def test_a_peer_without_power_ends_the_connection_within_seconds(bus: GatewayBus) -> None:
    # Power cannot be cut here: only the options given to the system can be checked.
    connection = bus._connection
    assert connection.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) == 1
    if hasattr(socket, "TCP_USER_TIMEOUT"):
        assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == DEAD_S * 1000
        idle, interval, count = (
            connection.getsockopt(socket.IPPROTO_TCP, option)
            for option in (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT)
        )
        assert idle + interval * count == DEAD_S


class Watched:
    """A connection that notes when the system was asked to acknowledge at once."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self.asked = 0

    def setsockopt(self, level: int, option: int, value: int) -> None:
        assert (level, option, value) == (socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
        self.asked += 1
        self._connection.setsockopt(level, option, value)

    def __getattr__(self, name: str) -> object:
        return getattr(self._connection, name)


@pytest.mark.skipif(not hasattr(socket, "TCP_QUICKACK"), reason="this system has no such option")
def test_received_frames_are_acknowledged_at_once_unless_own_frames_do_it(there: Gateway, bus: GatewayBus) -> None:
    watched = Watched(bus._connection)
    vars(bus)["_connection"] = watched

    def hear() -> int:
        there.connections[-1].sendall(b"< frame 012 1.5 00 >")
        assert select.select((bus,), (), (), 2.0)[0]
        assert len(bus.take_some()[0]) == 1
        return watched.asked

    assert [hear(), hear()] == [1, 2]
    bus.send_all([(0x123, b"\x01")])
    assert [hear(), hear()] == [2, 3]
