"""Only a connection that sends much without a packet is ended."""

import socket
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from common.link.curve import Sender
from common.link.endless_messages import EndlessMessages
from common.link.tcp_connections import connection_number

MIB = 1 << 20


class Lines:
    """Connections to one port, with both ends in the test's hands."""

    def __init__(self, opened: ExitStack) -> None:
        self._opened = opened
        self._server = opened.enter_context(socket.create_server(("127.0.0.1", 0)))
        self.port: int = self._server.getsockname()[1]

    def connect(self) -> tuple[socket.socket, socket.socket]:
        far = self._opened.enter_context(socket.create_connection(("127.0.0.1", self.port)))
        return far, self._opened.enter_context(self._server.accept()[0])


@pytest.fixture
def lines() -> Iterator[Lines]:
    with ExitStack() as opened:
        yield Lines(opened)


def send(ends: tuple[socket.socket, socket.socket], count: int) -> None:
    """Send this many bytes, and read them at the other end."""
    far, near = ends
    for _ in range(0, count, 4096):
        far.sendall(bytes(4096))
        near.recv(4096, socket.MSG_WAITALL)


def is_ended(ends: tuple[socket.socket, socket.socket]) -> bool:
    ends[0].setblocking(False)
    try:
        return ends[0].recv(1) == b""
    except BlockingIOError:
        return False


def heard(messages: EndlessMessages, ends: tuple[socket.socket, socket.socket]) -> None:
    messages.heard([(Sender(b"", "key", connection_number(ends[1].fileno())), b"packet")])


def test_only_a_connection_without_packets_is_ended(lines: Lines) -> None:
    messages, talker, endless, idle = EndlessMessages(lines.port), lines.connect(), lines.connect(), lines.connect()
    for _ in range(3):
        send(talker, 2 * MIB)
        heard(messages, talker)
        messages.step()
    assert messages.ended == 0
    send(endless, 2 * MIB)
    messages.step()
    assert messages.ended == 1
    assert [is_ended(each) for each in (talker, endless, idle)] == [False, True, False]


def test_a_packet_before_does_not_excuse_a_message_without_an_end(lines: Lines) -> None:
    messages, ends = EndlessMessages(lines.port), lines.connect()
    heard(messages, ends)
    messages.step()
    send(ends, 2 * MIB)
    messages.step()
    assert is_ended(ends)


def test_little_traffic_without_packets_is_permitted_for_long(lines: Lines) -> None:
    """A reader of another make may send its library's own heartbeats."""
    messages, ends = EndlessMessages(lines.port), lines.connect()
    for _ in range(100):
        send(ends, 4096)
        messages.step()
    assert not is_ended(ends)
