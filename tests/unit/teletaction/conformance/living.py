"""Emulated devices that live in a thread of their own, at real addresses."""

import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.thermal_sensor import ThermalSensor
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.serial_server import SerialServer, serve_serial
from sim_sensors.ports.socketcand import SocketcandBus

STEP_S = 0.002


@contextmanager
def alive(loop: SelectLoop, step: Callable[[float], None]) -> Iterator[None]:
    """Lets a device live while the test talks to it."""
    ended = threading.Event()

    def live() -> None:
        while not ended.is_set():
            loop.serve(STEP_S)
            step(loop.now())

    thread = threading.Thread(target=live)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@contextmanager
def thermal_sensor(address: str = "pty", silent: bool = False) -> Iterator[SerialServer]:
    """The index finger's thermal sensor."""
    loop = SelectLoop()
    server = serve_serial(ThermalSensor(1, loop.now()), loop, address, "thermal")
    server.silent = silent
    with closing(server), alive(loop, server.pump):
        yield server


@contextmanager
def exoskeleton(node: Exoskeleton) -> Iterator[SocketcandBus]:
    """An exoskeleton on a bus."""
    loop = SelectLoop()

    def step(now_s: float) -> None:
        node.force_n(now_s)
        bus.pump(now_s)

    with closing(SocketcandBus(loop, "127.0.0.1", 0, [node])) as bus, alive(loop, step):
        yield bus
