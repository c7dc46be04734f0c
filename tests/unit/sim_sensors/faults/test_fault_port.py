import socket
import time
from collections.abc import Iterator
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_sensors.faults.fault_port import LONGEST_LINE, FaultPort
from sim_sensors.ports.select_loop import SelectLoop
from tests.unit.sim_sensors.stepped import until
from tests.waiting import wait_until


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
def machine() -> Machine:
    return Machine()


@pytest.fixture
def port(loop: SelectLoop, machine: Machine) -> Iterator[FaultPort]:
    port = FaultPort(loop, 0, machine.apply)
    yield port
    port.close()


def connect(port: FaultPort) -> socket.socket:
    client = socket.create_connection(("127.0.0.1", port.number))
    client.setblocking(False)
    return client


def heard(loop: SelectLoop, client: socket.socket, lines: int) -> list[str]:
    """What the port says until this number of lines has come."""
    data = bytearray()

    def came() -> bool:
        with suppress(BlockingIOError):
            data.extend(client.recv(4096))
        return data.count(b"\n") >= lines

    until(loop, came)
    return data.decode().splitlines()


def hung_up(client: socket.socket) -> bool:
    try:
        return not client.recv(4096)
    except BlockingIOError:
        return False
    except ConnectionResetError:
        return True


def test_a_line_is_answered_with_its_time_and_text_or_with_one_line_of_error(
    port: FaultPort, loop: SelectLoop, machine: Machine
) -> None:
    with connect(port) as client:
        before_ns = time.monotonic_ns()
        client.sendall(b"unplug can\r\nexplode\nmend\n")
        first, error, second = heard(loop, client, 3)
        ok, time_ns, text = first.split(" ", 2)
        assert (ok, text) == ("ok", "UNPLUG CAN")
        assert before_ns - 1000 <= int(time_ns) <= time.monotonic_ns()
        assert error == "error it has nothing to explode with"
        assert second.startswith("ok ")
    assert machine.obeyed == ["unplug can", "mend"]


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
        until(loop, lambda: hung_up(client))
    assert machine.obeyed == []


def still_there(loop: SelectLoop, port: FaultPort) -> bool:
    with connect(port) as client:
        client.sendall(b"still there\n")
        return heard(loop, client, 1)[0].endswith("STILL THERE")


def test_a_client_that_asks_and_never_listens_is_hung_up_on(port: FaultPort, loop: SelectLoop) -> None:
    with connect(port) as client:

        def ended() -> bool:
            try:
                client.send(b"words to be repeated\n" * 100)
            except BlockingIOError:
                return False
            except (BrokenPipeError, ConnectionResetError):
                return True
            return False

        wait_until(lambda: loop.serve(0.0) or ended(), "its answers were kept", every_s=0.0)  # type: ignore[func-returns-value]
    assert still_there(loop, port)


@pytest.mark.long
@given(st.lists(st.binary(max_size=300), max_size=5))
def test_no_bytes_stop_it(chunks: list[bytes]) -> None:
    loop, machine = SelectLoop(), Machine()
    port = FaultPort(loop, 0, machine.apply)
    try:
        with connect(port) as client:
            for chunk in chunks:
                try:
                    client.sendall(chunk)
                except (BrokenPipeError, ConnectionResetError):
                    break
                loop.serve(0.001)
        assert still_there(loop, port)
    finally:
        port.close()


def test_a_taken_port_is_named(port: FaultPort, loop: SelectLoop, machine: Machine) -> None:
    with pytest.raises(ValueError, match=f"fault port: cannot listen on 127.0.0.1:{port.number}"):
        FaultPort(loop, port.number, machine.apply)
