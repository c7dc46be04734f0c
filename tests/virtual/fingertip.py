"""One operator's fingertip on a virtual clock: plate physics, emulated module, driver, plate loop and gate."""

from collections.abc import Iterator
from contextlib import contextmanager

from common.faults.fault import Fault
from common.fingers import FINGERS
from common.limits import AGE_DEFAULT_S, PLATE_FAULT_C, WIDE, PlateRange
from common.timing.standstill import HostClock
from operator_site.devices.devices import OperatorDevices
from operator_site.safety.gated_output import Outputs
from operator_site.safety.operator_gate import OperatorGate
from operator_site.safety.sampled_wall import SampledWall
from operator_site.thermal.plates import PlateController
from sim_sensors import operator_devices
from sim_sensors.ports.select_loop import SelectLoop
from teletaction.testbed.memory_wiring import MemoryWiring
from tests.virtual import configurations
from tests.virtual.configurations import FINGER
from tests.virtual.session import COARSE_TICK_S, TICK_S

_INDEX = FINGERS.index(FINGER)
_CALM_C = 33.0


class Fingertip:
    """The finger that is in use, and all that heats or cools it; nothing is touched, set-points are the test's.

    Attributes:
        time_s: virtual time.
        fault: what the gate has latched, and when; None while it has not.
        driven_s: when the Peltiers were last driven.
        plate_peak_c, skin_peak_c: hottest since the last `watch`.
        plate_hot_s, skin_hot_s: for how long in all above PLATE_FAULT_C since then.
    """

    def __init__(self, profile: PlateRange, seed: int) -> None:
        self.time_s = 0.0
        wiring = MemoryWiring(lambda: self.time_s)
        self.simulation = operator_devices.OperatorDevices(
            configurations.sim_operator(seed), SelectLoop(lambda: self.time_s), wiring
        )
        self.devices = OperatorDevices(
            configurations.operator(AGE_DEFAULT_S), HostClock(lambda: round(self.time_s * 1e9)), wiring
        )
        self.gate = OperatorGate(profile, SampledWall(2.0, TICK_S))
        self.fault: tuple[float, Fault] | None = None
        self.driven_s = 0.0
        self.watch()
        self._loop = PlateController()
        self._looked_s = 0.0
        self._set_c = _CALM_C
        self._drive = 0.0

    def watch(self) -> None:
        """Restart the peaks and times."""
        self.plate_peak_c = self.skin_peak_c = 0.0
        self.plate_hot_s = self.skin_hot_s = 0.0

    @property
    def plate_c(self) -> float:
        """The plate's true temperature, C."""
        return float(self.simulation.plates.plate_c[_INDEX])

    def run(self, goal_c: float, seconds: float, tick_s: float = TICK_S) -> None:
        """Let time pass while a plate temperature is wanted, with the motor running; coarsely if time is long."""
        self.simulation.step_s = tick_s
        for _ in range(round(seconds / tick_s)):
            self._tick(goal_c, tick_s)

    def _tick(self, goal_c: float, tick_s: float) -> None:
        self.time_s = now_s = self.time_s + tick_s
        self.simulation.step(now_s)
        self.devices.read(now_s)
        for fault in self.devices.faults():
            self.gate.trip(fault)
        plate_c, age_s = self.devices.plates(now_s)
        if now_s - self._looked_s > COARSE_TICK_S - 1e-6:
            self._looked_s = now_s
            self._drive = self._loop.step(now_s, self._set_c, plate_c[_INDEX])
        five = len(FINGERS)
        output = self.gate.step(
            now_s,
            True,
            0.0,
            Outputs([0.0] * five, [5000.0] * five, [goal_c] * five, [self._drive] * five, [0] * five),
            plate_measured_c=plate_c,
            measurement_age_s=age_s,
            z_m=[0.0] * five,
            height_age_s=0.0,
        )
        self._set_c = output.plate_set_c[_INDEX]
        self.devices.write(now_s, output, True)
        if output.fault is not None and self.fault is None:
            self.fault = now_s, output.fault
        self._observe(tick_s)

    def _observe(self, tick_s: float) -> None:
        skin_c = float(self.simulation.plates.surface_c[_INDEX])
        self.plate_peak_c = max(self.plate_peak_c, self.plate_c)
        self.skin_peak_c = max(self.skin_peak_c, skin_c)
        self.plate_hot_s += tick_s * (self.plate_c > PLATE_FAULT_C)
        self.skin_hot_s += tick_s * (skin_c > PLATE_FAULT_C)
        module = self.simulation.modules[FINGER]
        if module.motor_mv or module.drive_permille:
            self.driven_s = self.time_s


@contextmanager
def fingertip(profile: PlateRange = WIDE, seed: int = 0) -> Iterator[Fingertip]:
    """A fingertip whose module is connected and whose plate is held at skin temperature."""
    tip = Fingertip(profile, seed)
    try:
        tip.run(_CALM_C, 1.0)
        yield tip
    finally:
        tip.devices.close()
        tip.simulation.close()
