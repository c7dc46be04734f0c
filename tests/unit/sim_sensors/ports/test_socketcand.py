import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack

import can
import pytest

from common.buses.can_frames import SentFrame
from sim_sensors.ports.intruder import AHEAD, Intruder
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.socketcand import MOST_CLIENTS, QUIET_S, SocketcandBus
from tests.unit.sim_sensors.stepped import until
from tests.unit.teletaction.conformance.living import alive
from tests.waiting import wait_until


class Echo:
    """A node that keeps what it hears and sends what it is given."""

    def __init__(self) -> None:
        self.heard: list[tuple[int, bytes]] = []
        self.to_send: list[SentFrame] = []

    def feed(self, frame_id: int, data: bytes, now_s: float) -> None:
        self.heard.append((frame_id, data))

    def take_turn(self) -> list[SentFrame]:
        frames, self.to_send = self.to_send, []
        return frames


@pytest.fixture
def node() -> Echo:
    return Echo()


@pytest.fixture
def bus(loop: SelectLoop, node: Echo) -> Iterator[SocketcandBus]:
    bus = SocketcandBus(loop, "127.0.0.1", 0, [node])
    yield bus
    bus.close()


@pytest.fixture
def pumped(loop: SelectLoop, bus: SocketcandBus) -> Iterator[SocketcandBus]:
    """The bus, served by a thread: python-can's client blocks while it says hello."""
    with alive(loop, bus.pump):
        yield bus


def client(bus: SocketcandBus) -> can.BusABC:
    return can.Bus(interface="socketcand", host="127.0.0.1", port=bus.port, channel="can0")


FRAMES = [
    can.Message(arbitration_id=0x110, data=bytes(range(8)), is_extended_id=False),
    can.Message(arbitration_id=0x7FF, data=b"", is_extended_id=False),
    can.Message(arbitration_id=0x12, data=b"\xff\x00\x0a", is_extended_id=False),
    can.Message(arbitration_id=0x1ABCDEF0, data=b"\x01", is_extended_id=True),
]


def sent(frame: can.Message) -> SentFrame:
    return frame.arbitration_id, bytes(frame.data)


def test_python_can_sends_to_the_node_which_hears_11_bit_identifiers_only(pumped: SocketcandBus, node: Echo) -> None:
    extended = can.Message(arbitration_id=0x110, data=b"\x02", is_extended_id=True)
    heard = FRAMES[:3]
    with client(pumped) as can_bus:
        for frame in (extended, FRAMES[3], *heard):
            can_bus.send(frame)
        wait_until(lambda: len(node.heard) >= len(heard))
    assert node.heard == [sent(frame) for frame in heard]
    assert pumped.not_understood == 0


def test_python_can_hears_the_node_and_the_other_client_but_not_itself(pumped: SocketcandBus, node: Echo) -> None:
    with client(pumped) as one, client(pumped) as other:
        one.send(FRAMES[0])
        heard = other.recv(2.0 + QUIET_S)
        if heard is None:  # still within the quiet time after its hello
            one.send(FRAMES[0])
            heard = other.recv(2.0)
        assert heard is not None
        assert (heard.arbitration_id, bytes(heard.data)) == (0x110, bytes(range(8)))
        for frame in FRAMES[2:]:
            other.send(frame)
            heard = one.recv(2.0)
            assert heard is not None
            assert (heard.arbitration_id, heard.is_extended_id) == (frame.arbitration_id, frame.is_extended_id)
        node.to_send = [sent(FRAMES[2]), sent(FRAMES[0])]
        for each in (one, other):
            ids = [message.arbitration_id for message in iter(lambda each=each: each.recv(0.3), None)]  # type: ignore[misc]
            assert ids == [0x12, 0x110]


def test_clients_may_come_and_go_on_a_busy_bus(bus: SocketcandBus, loop: SelectLoop, node: Echo) -> None:
    def babble(now_s: float) -> None:
        node.to_send.append(sent(FRAMES[0]))
        bus.pump(now_s)

    with alive(loop, babble):
        for _ in range(5):  # the hello must come through although frames wait to be sent
            with client(bus) as can_bus:
                assert can_bus.recv(2.0) is not None
        wait_until(lambda: bus.clients == 0)


def said(loop: SelectLoop, connection: socket.socket, text: bytes = b"") -> bytes:
    connection.sendall(text)
    loop.serve(0.02)
    try:
        return connection.recv(4096)
    except BlockingIOError:
        return b""


def test_the_hello_word_for_word(bus: SocketcandBus, loop: SelectLoop, node: Echo) -> None:
    with socket.create_connection(("127.0.0.1", bus.port)) as connection:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        assert said(loop, connection) == b"< hi >"
        assert said(loop, connection, b"< open vcan7 >") == b"< error could not open bus >"
        assert said(loop, connection, b"< open can0 >") == b"< ok >"
        assert said(loop, connection, b"< rawmode >") == b"< ok >"
        said(loop, connection, b"< send 110 2 a")
        said(loop, connection, b" ff >< send 12 0 >")
        assert node.heard == [(0x110, b"\x0a\xff"), (0x12, b"")]
        node.to_send = [sent(FRAMES[2])]
        bus.pump(12.5)
        assert said(loop, connection) == b""  # a time before the hello: the client is not listening yet
        node.to_send = [sent(FRAMES[2])]
        now_s = loop.now()
        bus.pump(now_s)
        assert said(loop, connection) == f"< frame 012 {now_s:.6f} ff000a >".encode()


@pytest.mark.parametrize(
    "nonsense",
    [
        b"< send >",
        b"< send 110 3 1 2 >",
        b"< send xyz 1 1 >",
        b"< send 110 1 100 >",
        b"< send 800 1 1 >",
        b"< send 110 9 1 2 3 4 5 6 7 8 9 >",
        b"< bcm >",
        b"\xff\xfe>",
        b"<" * 500,
    ],
)
def test_nonsense_is_counted_and_harms_nobody(
    nonsense: bytes, bus: SocketcandBus, loop: SelectLoop, node: Echo
) -> None:
    with socket.create_connection(("127.0.0.1", bus.port)) as connection:
        connection.setblocking(False)
        said(loop, connection, nonsense)
        assert node.heard == []
        assert bus.not_understood >= 1
        said(loop, connection, b"> < send 111 1 7 >")
        assert node.heard == [(0x111, b"\x07")]


def test_a_client_that_never_reads_does_not_stop_the_bus(bus: SocketcandBus, loop: SelectLoop, node: Echo) -> None:
    with socket.create_connection(("127.0.0.1", bus.port)) as connection:
        connection.setblocking(False)
        said(loop, connection, b"< rawmode >< send 110 1 1 >")
        start = time.monotonic()
        for _ in range(200):
            node.to_send = [sent(FRAMES[0])] * 200
            bus.pump(loop.now())
        assert time.monotonic() - start < 2.0
        assert bus.clients == 1


@pytest.fixture
def listener(bus: SocketcandBus, loop: SelectLoop) -> Iterator[socket.socket]:
    """A client that is past its hello."""
    with socket.create_connection(("127.0.0.1", bus.port)) as connection:
        connection.setblocking(False)
        said(loop, connection, b"< open can0 >< rawmode >< send 7 0 >")
        yield connection


def test_idle_connections_are_limited_and_take_no_place_of_a_driver(
    bus: SocketcandBus, loop: SelectLoop, node: Echo, listener: socket.socket
) -> None:
    with ExitStack() as opened:
        for _ in range(3 * MOST_CLIENTS):
            opened.enter_context(socket.create_connection(("127.0.0.1", bus.port)))
            loop.serve(0.0)
        until(loop, lambda: bus.clients == MOST_CLIENTS)
        listener.sendall(b"< send 110 1 1 >")
        until(loop, lambda: (0x110, b"\x01") in node.heard)


def test_a_silent_node_passes_no_frame_either_way_and_a_deaf_one_sends_and_the_connection_stays(
    bus: SocketcandBus, loop: SelectLoop, node: Echo, listener: socket.socket
) -> None:
    node.heard.clear()

    def sends(request: bytes) -> bytes:
        node.to_send = [sent(FRAMES[2])]
        bus.pump(loop.now())
        return said(loop, listener, request)

    bus.silent = True
    assert sends(b"< send 110 1 1 >") == b""
    bus.silent, bus.deaf = False, True
    assert b"< frame 012 " in sends(b"< send 110 1 1 >")
    assert (node.heard, bus.clients) == ([], 1)
    bus.deaf = False
    assert b"< frame 012 " in sends(b"< send 111 1 7 >")
    assert node.heard == [(0x111, b"\x07")]


def test_frames_that_piled_up_while_the_process_stood_still_are_taken_at_once(
    bus: SocketcandBus, loop: SelectLoop, node: Echo, listener: socket.socket
) -> None:
    node.heard.clear()
    frames = b"".join(b"< send 110 2 %02X %02X >" % divmod(n, 256) for n in range(1000))
    listener.sendall(frames)  # into the connection's buffers: nobody reads meanwhile
    loop.serve(0.0)
    assert len(node.heard) > 500, "what came so far is read in one go"
    until(loop, lambda: len(node.heard) == 1000)
    assert [int.from_bytes(data, "big") for _, data in node.heard] == list(range(1000))


def test_an_unplugged_gateway_hangs_up_refuses_and_answers_at_the_same_port_again(
    bus: SocketcandBus, loop: SelectLoop, node: Echo, listener: socket.socket
) -> None:
    for _ in range(2):
        bus.unplug()
        assert bus.clients == 0
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", bus.port))
        bus.pump(loop.now())
        bus.plug()
        with socket.create_connection(("127.0.0.1", bus.port)) as connection:
            connection.setblocking(False)
            assert said(loop, connection) == b"< hi >"
    assert listener.recv(1000) == b"" or listener.recv(1000) == b""  # what was said before, then the end


def test_a_taken_port_is_named(bus: SocketcandBus, loop: SelectLoop) -> None:
    with pytest.raises(ValueError, match=f"CAN bus can0: cannot listen on 127.0.0.1:{bus.port}"):
        SocketcandBus(loop, "127.0.0.1", bus.port)


def test_a_second_sender_is_heard_by_the_node_and_by_the_client_that_it_answers(
    bus: SocketcandBus, loop: SelectLoop, node: Echo, listener: socket.socket
) -> None:
    node.heard.clear()
    bus.intruder = Intruder({"HandSetpoint": {"x": 1.0, "y": 0.0}})
    bus.intruder.active = True
    heard = said(loop, listener, b"< send 200 8 0 0 0 0 0 0 3 0 >")
    assert heard.startswith(b"< frame 200 ")
    assert [(frame_id, data[6]) for frame_id, data in node.heard] == [(0x200, 3), (0x200, 3 + AHEAD)]
