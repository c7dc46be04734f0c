"""A supervisor receives notices on its socket, and a missing one changes nothing."""

import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from common.runtime.systemd_notify import Supervisor


@pytest.fixture(params=["notify", "site@remote", "abstract"])
def listener(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[str, socket.socket]]:
    abstract = f"@teletaction-test-{threading.get_native_id()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        address = abstract if request.param == "abstract" else str(tmp_path / request.param)
        heard.bind(f"\0{address[1:]}" if address == abstract else address)
        heard.settimeout(10.0)
        yield address, heard


def test_each_notice_is_one_datagram(listener: tuple[str, socket.socket]) -> None:
    address, heard = listener
    with Supervisor(address) as supervisor:
        supervisor.ready()
        supervisor.alive("fault: thumb\nis hot")
    assert [heard.recv(1000) for _ in range(3)] == [
        b"READY=1",
        b"WATCHDOG=1\nSTATUS=fault: thumb is hot",
        b"STOPPING=1",
    ]


def test_the_environment_names_the_supervisor(
    listener: tuple[str, socket.socket], monkeypatch: pytest.MonkeyPatch
) -> None:
    address, heard = listener
    monkeypatch.setenv("NOTIFY_SOCKET", address)
    supervisor = Supervisor()
    supervisor.ready()
    supervisor.close()
    supervisor.ready()  # after closing: nothing, and no error
    assert heard.recv(1000) == b"READY=1"
    heard.setblocking(False)
    with pytest.raises(BlockingIOError):
        heard.recv(1000)


@pytest.mark.parametrize("address", ["", "vsock:2:1234", "/nowhere/at/all", "@nobody-listens-here"])
def test_a_missing_supervisor_is_no_error(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    with Supervisor(address or None) as supervisor:
        supervisor.ready()
        supervisor.alive("engaged")


def test_a_supervisor_that_does_not_read_does_not_hold_the_loop(listener: tuple[str, socket.socket]) -> None:
    address, heard = listener
    supervisor = Supervisor(address)
    for _ in range(10_000):
        supervisor.alive("engaged")  # far more than the socket takes
    assert heard.recv(1000).startswith(b"WATCHDOG=1")
    supervisor.close()
