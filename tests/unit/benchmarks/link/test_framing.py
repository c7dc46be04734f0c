"""Bytes of a packet on the wire as the study computes them, counted on a real connection."""

import socket
import threading
from pathlib import Path
from typing import Protocol

import pytest

from benchmarks.link.packets import framed_bytes
from common.link.keys import TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.wire.streams import STREAMS
from teletaction.session.demo_ports import free_port_block

COUNT = 20


class Keys(Protocol):
    remote: Path
    operator: Path


class Relay:
    """Passes one connection on, and counts what comes back from the server."""

    def __init__(self, port: int, server_port: int):
        self.counted = 0
        self._listener = socket.create_server(("127.0.0.1", port))
        self._server_port = server_port
        self._sockets: list[socket.socket] = [self._listener]
        self._threads = [threading.Thread(target=self._accept)]
        self._threads[0].start()

    def _accept(self) -> None:
        client, _ = self._listener.accept()
        server = socket.create_connection(("127.0.0.1", self._server_port))
        self._sockets += [client, server]
        self._threads.append(threading.Thread(target=self._pass_on, args=(client, server, False)))
        self._threads[-1].start()
        self._pass_on(server, client, True)

    def _pass_on(self, source: socket.socket, sink: socket.socket, count: bool) -> None:
        while part := source.recv(65536):
            if count:
                self.counted += len(part)
            try:
                sink.sendall(part)
            except OSError:
                return

    def close(self) -> None:
        for each in self._sockets[1:]:
            each.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join()
        for each in self._sockets:
            each.close()


@pytest.mark.parametrize("size", [100, 500])
def test_a_packet_takes_as_many_bytes_as_the_study_says(keys: Keys, base_port: int, size: int) -> None:
    server_port = base_port + STREAMS["touch"].port
    relay_base = free_port_block(len(STREAMS))
    remote_keys = load_keys(keys.remote)
    relay = Relay(relay_base + STREAMS["touch"].port, server_port)
    with RemoteLink("127.0.0.1", base_port, remote_keys, TrustedKeys(keys.remote)) as remote:
        with OperatorLink("127.0.0.1", relay_base, load_keys(keys.operator), remote_keys.public) as operator:
            while operator.wait_for_latest("touch", 0.01) is None:
                remote.send_latest("touch", bytes(size))
            while operator.wait_for_latest("touch", 0.1) is not None:
                pass
            before = relay.counted
            for _ in range(COUNT):  # one by one: what is superseded is not sent
                remote.send_latest("touch", bytes(size))
                assert operator.wait_for_latest("touch", 5.0) is not None
            taken = relay.counted - before
        relay.close()
    # The library's own heartbeats, twice a second, come on top.
    assert 0 <= taken - COUNT * framed_bytes(size) < framed_bytes(size)


def test_nothing_comes_of_waiting_for_nobody(keys: Keys, base_port: int) -> None:
    with RemoteLink("127.0.0.1", base_port, load_keys(keys.remote), TrustedKeys(keys.remote)) as remote:
        assert remote.wait_for_latest("motion", 0.01) is None
        assert remote.wait_for_latest("no such stream", 0.01) is None
