"""Cables pulled out of running drivers and put back: found again at the same address, on a terminal as over TCP."""

import os
import socket
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from serial.urlhandler import protocol_socket

from common.can_line import CanAddress
from common.serial_line import open_line
from common.serial_port import DeviceAbsent
from operator_site.exoskeleton import Exoskeleton as ExoskeletonDriver
from operator_site.tacttip import TactTip as TactTipDriver
from sim_sensors.exoskeleton import Exoskeleton
from sim_sensors.select_loop import SelectLoop
from sim_sensors.serial_server import SerialServer, serve_serial
from sim_sensors.socketcand import SocketcandBus
from sim_sensors.tacttip import TactTip


def until(turn: Callable[[], object], done: Callable[[], object], seconds: float = 10.0) -> None:
    deadline = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < deadline, "nothing came of it"
        turn()


class SerialRig:
    """A TactTip, its driver, and their turns."""

    def __init__(self, address: str) -> None:
        self.loop = SelectLoop()
        self.server: SerialServer = serve_serial(TactTip(1, self.loop.now()), self.loop, address, "tacttip index")
        self.driver = TactTipDriver("index", self.server.address)

    def turn(self) -> None:
        self.loop.serve(0.001)
        self.server.pump(self.loop.now())
        self.driver.read(time.monotonic())


@pytest.fixture(params=["tcp:127.0.0.1:0", "pty"])
def rig(request: pytest.FixtureRequest) -> Iterator[SerialRig]:
    rig = SerialRig(request.param)
    until(rig.turn, lambda: rig.driver.line.connected)
    yield rig
    rig.driver.line.close()
    rig.server.close()


def test_a_serial_device_is_found_again_under_its_old_address(rig: SerialRig) -> None:
    line = rig.driver.line
    for times in (1, 2):
        rig.server.unplug()
        until(rig.turn, lambda: not line.connected and line.problem is not None)
        assert isinstance(line.problem, DeviceAbsent)
        assert line.times_lost == times
        since_s = rig.driver.measured_s
        rig.server.plug()
        until(rig.turn, lambda: line.connected)
        until(rig.turn, lambda since_s=since_s: rig.driver.measured_s > since_s)  # type: ignore[misc]


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="this system does not list open files")
def test_a_cable_pulled_many_times_leaves_nothing_open(rig: SerialRig) -> None:
    line = rig.driver.line
    before = open_files()
    for _ in range(5):
        rig.server.unplug()
        until(rig.turn, lambda: not line.connected)
        rig.server.plug()
        until(rig.turn, lambda: line.connected)
    until(rig.turn, lambda: open_files() <= before)  # what was lost is closed beside the loop


def test_a_connection_that_is_reset_while_it_is_opened_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []

    def reset(port: protocol_socket.Serial) -> None:
        client, _ = listener.accept()
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        client.close()
        opened.append(port._socket)

    # The library does this once it is connected, and before it clears what has come.
    monkeypatch.setattr(protocol_socket.Serial, "_update_dtr_state", reset)
    with socket.create_server(("127.0.0.1", 0)) as listener, pytest.raises(DeviceAbsent, match="reset"):
        open_line(f"socket://127.0.0.1:{listener.getsockname()[1]}", 921_600)
    assert [connection.fileno() for connection in opened] == [-1]


def test_a_gateway_that_is_only_listened_to_is_missed_and_found_again() -> None:
    loop, node = SelectLoop(), Exoskeleton()
    bus = SocketcandBus(loop, "127.0.0.1", 0, [node])
    driver = ExoskeletonDriver(CanAddress(interface="socketcand", port=bus.port))

    def turn() -> None:
        loop.serve(0.001)
        bus.pump(loop.now())
        driver.read(time.monotonic())  # and never sends, which would find out by itself

    try:
        until(turn, lambda: driver.hand.oldest_s > 0.0)
        for times in (1, 2):
            bus.unplug()
            until(turn, lambda: isinstance(driver.line.problem, DeviceAbsent))
            assert driver.line.times_lost == times
            since_s = driver.hand.oldest_s
            bus.plug()
            until(turn, lambda since_s=since_s: driver.hand.oldest_s > since_s)  # type: ignore[misc]
    finally:
        driver.line.close()
        bus.close()
