import socket
import time
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_sensors.fault_port import LONGEST_LINE, FaultPort
from sim_sensors.select_loop import SelectLoop


class Machine:
    """Something that obeys all words but one."""

    def __init__(self) -> None:
        self.obeyed: list[str] = []

    def apply(self, line: str) -> str:
        if line == "explode":
            raise ValueError("it has nothing\nto explode with")
        self.obeyed.append(line)
        return line.upper()


@pytest.fixture
def loop() -> SelectLoop:
    return SelectLoop()


@pytest.fixture
def machine() -> Machine:
    return Machine()


@pytest.fixture
def port(loop: SelectLoop, machine: Machine) -> Iterator[FaultPort]:
    port = FaultPort(loop, "127.0.0.1", 0, machine.apply)
    yield port
    port.close()


def connect(port: FaultPort) -> socket.socket:
    client = socket.create_connection(("127.0.0.1", port.number))
    client.setblocking(False)
    return client


def heard(loop: SelectLoop, client: socket.socket, lines: int) -> list[str]:
    """That many lines of answer, or fewer if the port hangs up or says no more for two seconds."""
    deadline = time.monotonic() + 2.0
    data = b""
    while data.count(b"\n") < lines and time.monotonic() < deadline:
        loop.serve(0.002)
        try:
            chunk = client.recv(4096)
        except BlockingIOError:
            continue
        if not chunk:
            break
        data += chunk
    return data.decode().splitlines()


def hung_up(loop: SelectLoop, client: socket.socket) -> bool:
    deadline = time.monotonic() + 2.0
    while time.monotonic() < deadline:
        loop.serve(0.002)
        try:
            if not client.recv(4096):
                return True
        except BlockingIOError:
            continue
        except ConnectionResetError:
            return True
    return False


def test_an_obeyed_line_is_answered_with_its_time_and_text(port: FaultPort, loop: SelectLoop, machine: Machine) -> None:
    with connect(port) as client:
        before_ns = time.monotonic_ns()
        client.sendall(b"unplug can\r\n")
        (answer,) = heard(loop, client, 1)
        ok, time_ns, text = answer.split(" ", 2)
        assert (ok, text) == ("ok", "UNPLUG CAN")
        assert before_ns - 1000 <= int(time_ns) <= time.monotonic_ns()
    assert machine.obeyed == ["unplug can"]


def test_what_cannot_be_done_is_one_line_of_error_and_the_client_may_go_on(
    port: FaultPort, loop: SelectLoop, machine: Machine
) -> None:
    with connect(port) as client:
        client.sendall(b"explode\nmend\n")
        error, ok = heard(loop, client, 2)
        assert error == "error it has nothing to explode with"
        assert ok.startswith("ok ")
    assert machine.obeyed == ["mend"]


def test_every_client_has_its_own_line_and_one_that_goes_harms_no_other(
    port: FaultPort, loop: SelectLoop, machine: Machine
) -> None:
    clients = [connect(port) for _ in range(10)]
    for client in clients:
        client.sendall(b"half a li")
    loop.serve(0.02)
    for gone in clients[::2]:
        gone.close()
    for number, client in enumerate(clients[1::2]):
        client.sendall(b"ne %d\n" % number)
    for number, client in enumerate(clients[1::2]):
        assert heard(loop, client, 1)[0].endswith(f"HALF A LINE {number}")
        client.close()
    assert machine.obeyed == [f"half a line {number}" for number in range(5)]


def test_a_line_without_end_is_refused_and_hung_up_on(port: FaultPort, loop: SelectLoop, machine: Machine) -> None:
    with connect(port) as client:
        client.sendall(b"x" * (LONGEST_LINE + 1))
        assert heard(loop, client, 1) == [f"error a line is at most {LONGEST_LINE} bytes"]
        assert hung_up(loop, client)
    assert machine.obeyed == []


def test_a_client_that_asks_and_never_listens_is_hung_up_on(port: FaultPort, loop: SelectLoop) -> None:
    with connect(port) as client:
        deadline = time.monotonic() + 10.0
        ended = False
        while not ended:
            assert time.monotonic() < deadline, "its answers went on being kept"
            try:
                client.send(b"words to be repeated\n" * 100)
            except BlockingIOError:
                pass
            except (BrokenPipeError, ConnectionResetError):
                ended = True
            loop.serve(0.0)
    with connect(port) as other:
        other.sendall(b"still there\n")
        assert heard(loop, other, 1)[0].endswith("STILL THERE")


@given(st.lists(st.binary(max_size=300), max_size=5))
def test_no_bytes_stop_it(chunks: list[bytes]) -> None:
    loop, machine = SelectLoop(), Machine()
    port = FaultPort(loop, "127.0.0.1", 0, machine.apply)
    try:
        with connect(port) as client:
            for chunk in chunks:
                try:
                    client.sendall(chunk)
                except (BrokenPipeError, ConnectionResetError):
                    break
                loop.serve(0.001)
        with connect(port) as client:
            client.sendall(b"still there\n")
            assert heard(loop, client, 1)[0].endswith("STILL THERE")
    finally:
        port.close()


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.5", "example.org", ""])
def test_it_listens_on_loopback_only(host: str, loop: SelectLoop, machine: Machine) -> None:
    with pytest.raises(ValueError, match="not loopback"):
        FaultPort(loop, host, 0, machine.apply)


def test_a_taken_port_is_named(port: FaultPort, loop: SelectLoop, machine: Machine) -> None:
    with pytest.raises(ValueError, match=f"fault port: cannot listen on 127.0.0.1:{port.number}"):
        FaultPort(loop, "127.0.0.1", port.number, machine.apply)
