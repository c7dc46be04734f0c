"""Waiting for a site's devices at start: all there, or one clear line that says which is not."""

import time
from collections.abc import Callable
from typing import Protocol

from common.buses.serial_device import WrongDevice


class Devices(Protocol):
    """What can be waited for."""

    def read(self, t_s: float) -> object:
        """Take what the devices said."""

    def missing(self) -> str:
        """What is not there yet; empty when all is."""

    def problems(self) -> list[Exception]:
        """Why devices are not there."""


class DevicesMissing(ValueError):
    """A device is absent, or is another than the configuration says."""


def wait_for_devices(devices: Devices, patience_s: float, stop: Callable[[], bool] = lambda: False) -> bool:
    """Return True once all devices answered, or False as soon as `stop()`.

    Raises:
        DevicesMissing: one did not within `patience_s`, or another device answered in its place.
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
