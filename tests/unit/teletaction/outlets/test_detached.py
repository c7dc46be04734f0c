"""A server that hangs or fails delays neither the feed nor the end of the process."""

import threading
import time
from collections.abc import Sequence

import pytest

from teletaction.export.named_recording import NamedMessage
from teletaction.outlets import detached as module
from teletaction.outlets.detached import WAITING, Detached
from tests.conftest import Contained
from tests.waiting import wait_until


def batch(number: int) -> list[NamedMessage]:
    """A batch of two messages."""
    return [NamedMessage("operator/clock", number, number, {})] * 2


class Server:
    """Takes messages while the gate is open."""

    address = "nowhere"

    def __init__(self) -> None:
        self.taken: list[int] = []
        self.gate = threading.Event()
        self.closed = False

    def offer(self, messages: Sequence[NamedMessage]) -> None:
        self.gate.wait()
        self.taken.append(messages[0].monotonic_ns)

    def close(self) -> None:
        self.closed = True


def test_messages_arrive_in_order_and_the_server_is_closed() -> None:
    server = Server()
    server.gate.set()
    with Detached(server) as detached:
        for number in range(20):
            detached.offer(batch(number))
    assert server.taken == list(range(20))
    assert server.closed
    assert detached.dropped == 0


def test_messages_for_a_server_that_is_behind_are_dropped_and_counted() -> None:
    server = Server()
    with Detached(server) as detached:
        detached.offer(batch(0))
        wait_until(detached._batches.empty, "the server did not take the first batch")
        for number in range(1, WAITING + 11):
            detached.offer(batch(number))
        assert detached.dropped == 2 * 10
        server.gate.set()
    assert server.taken == list(range(WAITING + 1))


def test_a_server_that_hangs_does_not_keep_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "END_S", 0.05)
    server = Server()
    begun_s = time.monotonic()
    with Detached(server) as detached:
        detached.offer(batch(0))
        wait_until(detached._batches.empty, "the server did not take the first batch")
        for number in range(1, WAITING + 10):
            detached.offer(batch(number))
    assert time.monotonic() - begun_s < 2.0
    assert not server.closed
    assert detached._thread.daemon
    server.gate.set()
    detached._thread.join()
    assert server.closed
    assert server.taken == [0]


def test_a_failure_costs_one_batch(contained: Contained) -> None:
    class Failing(Server):
        def offer(self, messages: Sequence[NamedMessage]) -> None:
            super().offer(messages)
            if messages[0].monotonic_ns == 1:
                raise RuntimeError("no more clients")

    server = Failing()
    server.gate.set()
    with Detached(server) as detached:
        for number in range(3):
            detached.offer(batch(number))
    assert server.taken == [0, 1, 2]
    assert server.closed
    assert len(contained.take()) == 1
