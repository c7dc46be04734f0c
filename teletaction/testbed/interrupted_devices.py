"""Devices of a site that run a callback before or after their next reading, to stop the site in its tick."""

from collections.abc import Callable
from dataclasses import dataclass

from common.config import OperatorConfig, RemoteConfig
from common.timing.standstill import HostClock
from operator_site.devices.devices import OperatorDevices
from operator_site.devices.exoskeleton import Hand
from remote_site.devices.devices import RemoteDevices
from remote_site.devices.hand_path import HandPlace
from remote_site.devices.sensor_frame import SensorFrame
from teletaction.testbed.memory_wiring import MemoryWiring


@dataclass(slots=True)
class Interruption:
    """Callbacks that run once, before or after the next reading."""

    before: Callable[[], None] | None = None
    after: Callable[[], None] | None = None

    def take_before(self) -> None:
        """Run the callback due before a reading, once."""
        happens, self.before = self.before, None
        if happens is not None:
            happens()

    def take_after(self) -> None:
        """Run the callback due after a reading, once."""
        happens, self.after = self.after, None
        if happens is not None:
            happens()


class InterruptedRemoteDevices(RemoteDevices):
    """The remote site's devices with an interruption."""

    def __init__(self, config: RemoteConfig, clock: HostClock, wiring: MemoryWiring) -> None:
        super().__init__(config, clock, wiring)
        self.interruption = Interruption()

    def read(self, t_s: float, hand: HandPlace | None = None) -> SensorFrame:
        """As `RemoteDevices.read`."""
        self.interruption.take_before()
        sensed = super().read(t_s, hand)
        self.interruption.take_after()
        return sensed


class InterruptedOperatorDevices(OperatorDevices):
    """The operator site's devices with an interruption."""

    def __init__(self, config: OperatorConfig, clock: HostClock, wiring: MemoryWiring) -> None:
        super().__init__(config, clock, wiring)
        self.interruption = Interruption()

    def read(self, t_s: float) -> Hand:
        """As `OperatorDevices.read`."""
        self.interruption.take_before()
        hand = super().read(t_s)
        self.interruption.take_after()
        return hand
