"""Waits at start until all devices of a site answer, or reports which one is missing."""

import time
from collections.abc import Callable
from typing import Protocol

from common.buses.serial_device import WrongDevice


class Devices(Protocol):
    """Devices that a site waits for."""

    def read(self, t_s: float) -> object:
        """Read the devices."""

    def missing(self) -> str:
        """Return which devices are missing; empty when none is."""

    def problems(self) -> list[Exception]:
        """Return the reasons why devices are missing."""


class DevicesMissing(ValueError):
    """A device is absent, or differs from the one that the configuration names."""


def wait_for_devices(devices: Devices, patience_s: float, stop: Callable[[], bool] = lambda: False) -> bool:
    """Return True once all devices have answered, or False as soon as `stop()` is true.

    Raises:
        DevicesMissing: a device did not answer within `patience_s`, s, or another device answered in its place.
    """
    deadline_s = time.monotonic() + patience_s
    while not stop():
        devices.read(time.monotonic())
        missing = devices.missing()
        if not missing:
            return True
        wrong = next((problem for problem in devices.problems() if isinstance(problem, WrongDevice)), None)
        if wrong is not None:
            raise DevicesMissing(str(wrong))
        if time.monotonic() >= deadline_s:
            raise DevicesMissing(f"{missing} (waited {patience_s:g} s)")
        time.sleep(0.01)
    return False
