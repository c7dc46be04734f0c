"""One poll of all lines finds those with something to read, also after lost connections."""

import os
import socket
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from common.buses.ready_lines import ReadyLines


@dataclass
class End:
    """A line by its descriptor alone."""

    descriptor: int | None = None
    readable: bool | None = None


@pytest.fixture
def pair() -> Iterator[tuple[socket.socket, socket.socket]]:
    ends = socket.socketpair()
    yield ends
    for end in ends:
        end.close()


def looked(ready: ReadyLines, *lines: End) -> list[bool | None]:
    ready.look()
    return [line.readable for line in lines]


def test_only_a_line_with_something_to_read_is_readable(pair: tuple[socket.socket, socket.socket]) -> None:
    here, there = pair
    heard, silent = End(here.fileno()), End(there.fileno())
    ready = ReadyLines([heard, silent])
    assert looked(ready, heard, silent) == [False, False]
    there.sendall(b"a frame")
    assert looked(ready, heard, silent) == [True, False]
    here.recv(100)
    assert looked(ready, heard, silent) == [False, False]


def test_a_line_that_is_not_open_or_has_ended_is_readable(pair: tuple[socket.socket, socket.socket]) -> None:
    """Reading it takes a device up that has appeared, or notices the end."""
    absent, other = End(), End(pair[0].fileno())
    assert looked(ReadyLines([absent, other]), absent, other) == [True, False]
    pair[1].close()
    assert looked(ReadyLines([absent, other]), absent, other) == [True, True]


def test_lines_may_be_lost_and_opened_again_with_other_descriptors(pair: tuple[socket.socket, socket.socket]) -> None:
    line = End(pair[0].fileno())
    ready = ReadyLines([line])
    assert looked(ready, line) == [False]
    line.descriptor = None
    assert looked(ready, line) == [True]
    reading, writing = os.pipe()
    try:
        line.descriptor = reading
        assert looked(ready, line) == [False]
        os.write(writing, b"x")
        assert looked(ready, line) == [True]
    finally:
        os.close(reading)
        os.close(writing)
