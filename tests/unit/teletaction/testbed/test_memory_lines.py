"""Lines and buses in memory end like those of a real machine."""

import can
import pytest
import serial

from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from teletaction.testbed.memory_lines import MemoryBus, MemoryCan, MemoryLine, MemoryPort


def test_a_port_that_was_open_while_the_cable_was_out_stays_dead() -> None:
    line = MemoryLine(TactTip(0), lambda: 1.0, "tacttip")
    port = MemoryPort(line)
    line.unplug()
    line.plug()
    with pytest.raises(serial.SerialException):
        port.read()
    assert MemoryPort(line).read() == b""


def test_a_connection_to_a_bus_that_was_gone_stays_dead() -> None:
    bus = MemoryBus(lambda: 1.0, [Telemanipulator()])
    connection = MemoryCan(bus)
    bus.unplug()
    assert bus.clients == 0
    bus.plug()
    with pytest.raises(can.CanOperationError):
        connection.recv()
    again = MemoryCan(bus)
    bus.pump(1.0)
    assert again.recv() is not None
    connection.shutdown()
    assert bus.clients == 1
    again.shutdown()
