"""Devices of a site that run a callback before or after their next reading, to stop the site in its tick."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from common.config.site_models import OperatorConfig, RemoteConfig
from common.timing.standstill import HostClock
from operator_site.devices.devices import OperatorDevices
from operator_site.devices.exoskeleton import Hand
from remote_site.devices.devices import RemoteDevices
from remote_site.devices.sensor_frame import HandPlace, SensorFrame
from teletaction.testbed.memory_wiring import MemoryWiring

T = TypeVar("T")


@dataclass(slots=True)
class Interruption:
    """Callbacks that run once, before or after the next reading."""

    before: Callable[[], None] | None = None
    after: Callable[[], None] | None = None

    def around(self, read: Callable[[], T]) -> T:
        """Return a reading; run the callbacks around it."""
        before, self.before = self.before, None
        if before is not None:
            before()
        reading = read()
        after, self.after = self.after, None
        if after is not None:
            after()
        return reading


class InterruptedRemoteDevices(RemoteDevices):
    """The remote site's devices with an interruption."""

    def __init__(self, config: RemoteConfig, clock: HostClock, wiring: MemoryWiring) -> None:
        super().__init__(config, clock, wiring)
        self.interruption = Interruption()

    def read(self, t_s: float, hand: HandPlace | None = None) -> SensorFrame:
        """As `RemoteDevices.read`."""
        return self.interruption.around(partial(super().read, t_s, hand))


class InterruptedOperatorDevices(OperatorDevices):
    """The operator site's devices with an interruption."""

    def __init__(self, config: OperatorConfig, clock: HostClock, wiring: MemoryWiring) -> None:
        super().__init__(config, clock, wiring)
        self.interruption = Interruption()

    def read(self, t_s: float) -> Hand:
        """As `OperatorDevices.read`."""
        return self.interruption.around(partial(super().read, t_s))
