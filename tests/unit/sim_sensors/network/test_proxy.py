"""Real connections through the simulated network, on a clock that stands still unless a test moves it."""

import json
import socket
import struct
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest

from common.config.simulation_models import SimNetworkConfig
from common.wire.streams import STREAMS
from sim_sensors.network.proxy import NetworkProxy, run_sim_network
from sim_sensors.ports.select_loop import SelectLoop
from tests.ports import free_port

HOST = "127.0.0.1"
PORT = STREAMS["control"].port
TICK_S = 0.001
PLENTY = 20_000


class Bench:
    """A proxy for `control` between clients and a server of this test."""

    def __init__(self, base_port: int, network: str, **settings: object) -> None:
        self.now_s = 5000.0
        self.server = socket.create_server((HOST, 0))
        self.server.setblocking(False)
        self.sockets = SelectLoop(lambda: self.now_s)
        fields = {
            "network": network,
            "base_port": base_port,
            "to_base_port": self.server.getsockname()[1] - PORT,
        }
        self.config = SimNetworkConfig.model_validate(fields | settings)
        self.proxy = NetworkProxy(self.config, self.sockets)
        self.opened: list[socket.socket] = []

    def step(self, seconds: float = 0.0) -> None:
        """Let time pass in ticks; with 0, handle what is there now."""
        for _ in range(max(1, round(seconds / TICK_S))):
            self.now_s += TICK_S if seconds else 0.0
            self.sockets.serve(0.0)
            self.proxy.step(self.now_s)

    def until(self, done: Callable[[], object], seconds: float = 0.0) -> float:
        """Step until `done()`, by default without letting time pass; returns how much passed."""
        begin_s = self.now_s
        for _ in range(PLENTY):
            if done():
                return self.now_s - begin_s
            self.step(TICK_S if self.now_s - begin_s < seconds else 0.0)
        raise AssertionError("it never happened")

    def knock(self) -> socket.socket:
        client = socket.create_connection((HOST, self.config.base_port + PORT))
        client.setblocking(False)
        self.opened.append(client)
        return client

    def connection(self) -> tuple[socket.socket, socket.socket]:
        """A client, and what the server sees of it."""
        client = self.knock()
        found: list[socket.socket] = []

        def accepted() -> bool:
            try:
                found.append(self.server.accept()[0])
            except BlockingIOError:
                return False
            return True

        self.until(accepted)
        found[0].setblocking(False)
        self.opened += found
        self.step()
        return client, found[0]

    def control(self) -> dict[str, Any]:
        """What the proxy says of the stream."""
        return self.proxy.figures()["streams"]["control"]  # type: ignore[index, no-any-return]

    def in_flight(self, way: str = "to_remote") -> int:
        return int(self.control()[way]["in_flight_bytes"])

    def send(self, sender: socket.socket, data: bytes, way: str = "to_remote") -> None:
        """Send, and wait until it is on its way, without time passing."""
        before = self.in_flight(way)
        sender.sendall(data)
        self.until(lambda: self.in_flight(way) == before + len(data))

    def close(self) -> None:
        self.proxy.close()
        for end in (*self.opened, self.server):
            end.close()


def heard(end: socket.socket) -> bytes | None:
    """What has arrived: None for nothing, empty for the end."""
    try:
        return end.recv(1 << 20)
    except BlockingIOError:
        return None


def was_reset(end: socket.socket) -> bool:
    try:
        end.recv(1)
    except BlockingIOError:
        return False
    except ConnectionResetError:
        return True
    return False


@pytest.fixture
def benches(base_port: int) -> Iterator[Callable[..., Bench]]:
    """Makes a bench with a network and settings."""
    with ExitStack() as stage:

        def make(network: str, **settings: object) -> Bench:
            bench = Bench(base_port, network, **settings)
            stage.callback(bench.close)
            return bench

        yield make


@pytest.fixture
def bench(benches: Callable[..., Bench]) -> Bench:
    return benches("satellite")


def test_bytes_arrive_after_the_delay_and_not_before(bench: Bench) -> None:
    client, server = bench.connection()
    bench.send(client, b"hello")
    bench.step(0.279)
    assert heard(server) is None
    assert bench.until(lambda: heard(server) == b"hello", 0.1) < 0.003
    bench.send(server, b"welcome", "to_operator")
    bench.step(0.279)
    assert heard(client) is None
    assert bench.until(lambda: heard(client) == b"welcome", 0.1) < 0.003


def test_a_megabyte_each_way_arrives_whole(benches: Callable[..., Bench]) -> None:
    bench = benches("mobile")
    ends = bench.connection()
    sent = [bytes(n * k % 251 for n in range(1 << 20)) for k in (1, 3)]
    unsent = [memoryview(data) for data in sent]
    got = [bytearray(), bytearray()]

    def done() -> bool:
        for n, end in enumerate(ends):
            with suppress(BlockingIOError):
                unsent[n] = unsent[n][end.send(unsent[n]) :] if unsent[n] else unsent[n]
            got[1 - n] += heard(end) or b""
        return len(got[0]) == len(got[1]) == 1 << 20

    bench.until(done, 100.0)
    assert got == sent
    figures = bench.control()
    assert figures["to_remote"]["bytes"] == figures["to_operator"]["bytes"] == 1 << 20
    assert figures["to_remote"]["retransmitted"] > 0


def test_the_end_of_one_side_reaches_the_other_behind_its_last_byte(bench: Bench) -> None:
    client, server = bench.connection()
    bench.send(client, b"bye")
    client.shutdown(socket.SHUT_WR)
    bench.step(0.3)
    bench.until(lambda: heard(server) == b"bye")
    bench.until(lambda: heard(server) == b"", 0.3)
    bench.send(server, b"and you", "to_operator")
    server.close()
    bench.until(lambda: heard(client) == b"and you", 0.3)
    bench.until(lambda: heard(client) == b"", 0.3)
    bench.until(lambda: bench.control()["connections_open"] == 0)


def test_a_client_that_dies_takes_its_connection_with_it(bench: Bench) -> None:
    client, server = bench.connection()
    bench.send(server, b"never read", "to_operator")
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    client.close()
    bench.until(lambda: heard(server) == b"", 1.0)
    server.close()
    bench.until(lambda: bench.control()["connections_open"] == 0, 1.0)


def test_a_client_of_nobody_is_reset(bench: Bench) -> None:
    bench.server.close()
    client = bench.knock()
    bench.until(lambda: was_reset(client))


def test_a_cut_resets_both_ends_and_new_connections_work(bench: Bench) -> None:
    client, server = bench.connection()
    bench.send(client, b"lost")
    bench.proxy.obey("cut")
    bench.until(lambda: was_reset(client))
    bench.until(lambda: was_reset(server))
    again, second = bench.connection()
    bench.send(again, b"back")
    bench.until(lambda: heard(second) == b"back", 0.3)


def test_a_half_open_connection_swallows_everything_and_new_ones_work(bench: Bench) -> None:
    client, server = bench.connection()
    bench.send(client, b"on its way")
    bench.proxy.obey("half_open 5")
    for _ in range(4):
        client.sendall(b"hello?")
        server.sendall(b"hello?")
        bench.step(1.0)
        assert heard(client) is heard(server) is None
    again, second = bench.connection()
    bench.send(again, b"back")
    bench.until(lambda: heard(second) == b"back", 0.3)
    bench.step(1.0)
    bench.until(lambda: was_reset(client))
    bench.until(lambda: was_reset(server))
    bench.send(again, b"still here")
    bench.until(lambda: heard(second) == b"still here", 0.3)


def test_one_direction_of_a_connection_may_work(bench: Bench) -> None:
    client, server = bench.connection()
    bench.proxy.obey("half_open 5 to_operator")
    bench.send(client, b"heard")
    server.sendall(b"not heard")
    bench.until(lambda: heard(server) == b"heard", 0.3)
    bench.step(2.0)
    assert heard(client) is None


def test_a_partition_keeps_connections_and_lets_no_new_one_through(bench: Bench) -> None:
    client, server = bench.connection()
    bench.proxy.obey("partition 10")
    bench.send(client, b"late")
    late = bench.knock()
    late.sendall(b"me too")
    bench.step(9.9)
    assert heard(server) is heard(late) is None
    with pytest.raises(BlockingIOError):
        bench.server.accept()
    bench.until(lambda: heard(server) == b"late", 30.0)
    second, _ = bench.server.accept()
    second.setblocking(False)
    bench.opened.append(second)
    bench.until(lambda: heard(second) == b"me too", 30.0)


def test_a_client_that_gives_up_in_a_partition_is_forgotten(bench: Bench) -> None:
    bench.proxy.obey("partition 10")
    for _ in range(3):
        client = bench.knock()
        client.sendall(b"greeting")
        bench.until(lambda: bench.control()["connections_open"] == 1)
        client.close()
        bench.until(lambda: bench.control()["connections_open"] == 0)
    bench.step(10.1)
    with pytest.raises(BlockingIOError):
        bench.server.accept()


@pytest.mark.parametrize("network", ["slow", "lan"])
def test_a_sender_is_held_back_by_a_slow_network_and_by_a_receiver_that_never_reads(
    network: str, benches: Callable[..., Bench], tmp_path: Path
) -> None:
    slow = tmp_path / "slow.toml"
    slow.write_text("[[phase]]\nfrom_s = 0\nrate_kbit_s = 80\n", "utf-8")
    bench = benches(str(slow) if network == "slow" else network)
    client, _ = bench.connection()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 64 * 1024)
    sent = 0
    for _ in range(2000):
        with suppress(BlockingIOError):
            sent += client.send(bytes(64 * 1024))
        bench.step(0.0 if network == "slow" else TICK_S)
    assert sent < 10_000_000, "of 131 MB that were offered"
    assert network != "slow" or bench.in_flight() < 200_000


def ask(bench: Bench, client: socket.socket, line: str) -> str:
    client.sendall(line.encode() + b"\n")
    answers: list[bytes] = []
    bench.until(lambda: (answer := heard(client)) is not None and not answers.append(answer))  # type: ignore[func-returns-value]
    return answers[0].decode().strip()


def test_it_takes_commands_at_a_port(benches: Callable[..., Bench]) -> None:
    fault_port = free_port()
    bench = benches("bad_evening", fault_port=fault_port, wait_for_start=True)
    ends = bench.connection()
    bench.step(3.0)
    assert bench.proxy.figures()["faults"] == []
    with socket.create_connection((HOST, fault_port)) as client:
        client.setblocking(False)
        assert ask(bench, client, "start").startswith("ok 500300")
        assert ask(bench, client, "start") == "error start: the timetable is running already"
        assert ask(bench, client, "explode").startswith("error 'explode': expected partition")
        assert ask(bench, client, "cut").startswith("ok ")
        for end in ends:
            bench.until(lambda end=end: was_reset(end))  # type: ignore[misc]
        bench.step(2.5)
        assert ask(bench, client, "delay 400 20").startswith("ok ")
    figures = bench.proxy.figures()
    assert figures["delay_ms"] == 400.0
    assert figures["faults"] == [
        {"at_s": 0.0, "kind": "cut", "direction": "both"},
        {"at_s": 2.0, "kind": "stall", "seconds": 0.4, "direction": "both"},
    ]


def test_a_taken_port_is_named_and_the_others_are_given_back(base_port: int) -> None:
    config = SimNetworkConfig(network="lan", base_port=base_port)
    taken = base_port + PORT
    with socket.create_server((HOST, taken)), pytest.raises(ValueError, match=rf"control: cannot listen on .*:{taken}"):
        NetworkProxy(config, SelectLoop())
    NetworkProxy(config, SelectLoop()).close()


def test_the_process_writes_what_it_did(base_port: int, tmp_path: Path) -> None:
    config = SimNetworkConfig(network="lan", base_port=base_port, status=tmp_path / "network.json")
    ticks = iter(range(100))
    run_sim_network(config, lambda: next(ticks, None) is None)
    status = json.loads((tmp_path / "network.json").read_text("utf-8"))
    assert (status["process"], status["network"], status["started"]) == ("network", "lan", True)
    assert (status["loop"]["period_ms"], status["loop"]["ticks"]) == (1.0, 100)
    assert set(status["streams"]) == set(STREAMS)
