"""A session of one finger on the test bed, with the true state of that finger's actuators."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from common.fingers import FINGERS
from common.limits import AGE_DEFAULT_S
from common.recording.recorder import Recorder
from sim_sensors.ports.simulation_loop import STEP_S
from teletaction.testbed.memory_feed import MemoryFeed
from teletaction.testbed.site_clock import SiteClock
from teletaction.testbed.testbed import COARSE_STEP_S, Extras, SessionConfigs, Testbed
from tests.virtual import configurations
from tests.virtual.configurations import FINGER

TICK_S, COARSE_TICK_S = STEP_S, COARSE_STEP_S
_INDEX = FINGERS.index(FINGER)
_EARLY_M = 0.10
"""Of the way to 0.28 m, at 50 mm/s."""


class Truth(NamedTuple):
    """What really is at the actuators of the one finger in use, at both sites, at one moment of virtual time."""

    time_s: float
    force_n: float
    motor_mv: int
    motor_rpm: float
    peltier: float
    plate_c: float
    contact_n: float
    x_m: float
    z_m: float
    heater: float
    sensor_c: float
    """Of the thermal sensor's plate, which `heater` drives."""


class VirtualSession(Testbed):
    """One operator, one remote site, one finger each.

    Attributes:
        truth: what was at the actuators, one entry a step.
        watch: called after every step with its truth; a check that must always hold raises here.
    """

    def __init__(
        self,
        seed: int,
        max_age_s: float,
        recorders: Mapping[str, Recorder],
        feed: MemoryFeed | None = None,
        pressed_at_s: tuple[float, ...] | None = None,
    ) -> None:
        configs = SessionConfigs(
            configurations.sim_remote(seed, pressed_at_s),
            configurations.sim_operator(seed),
            configurations.remote(max_age_s, patient_switch=pressed_at_s is not None),
            configurations.operator(max_age_s, at_console=feed is not None),
        )
        super().__init__(configs, seed, Extras(SiteClock(7_200.123), SiteClock(100.456), recorders, feed))
        self.truth: list[Truth] = []
        self.watch: list[Callable[[VirtualSession, Truth], None]] = []
        self._tacttip = self.sim_operator.modules[FINGER]
        self._thermal = self.sim_remote.thermal[FINGER]

    @property
    def now(self) -> Truth:
        """What is at the actuators now."""
        return self.truth[-1]

    def tick(self) -> None:
        """Let one step pass, and watch what comes of it."""
        super().tick()
        truth = self._observe(self.time_s)
        self.truth.append(truth)
        for check in self.watch:
            check(self, truth)

    def run(self, seconds: float) -> list[Truth]:
        """Let time pass; returns what was at the actuators during it."""
        first = len(self.truth)
        super().run(seconds)
        return self.truth[first:]

    def run_coarsely(self, seconds: float) -> list[Truth]:
        """The same in long steps."""
        first = len(self.truth)
        super().run_coarsely(seconds)
        return self.truth[first:]

    @property
    def disobeyed(self) -> bool:
        """Whether the telemanipulator's servos are broken: where it goes is in nobody's hand."""
        return any(fault.startswith("disobey") for fault in self.sim_remote.faults.in_force)

    def work(self, patience_s: float = 20.0) -> float:
        """Let time pass until a stroke with three seconds left is felt; returns how long it took, s."""
        return self.until(lambda session: session.at_work and session.sim_operator.hand.x_m < _EARLY_M, patience_s)

    def resume(self, patience_s: float = 20.0) -> float:
        """Let time pass until a stroke is felt, however little of it is left; returns how long it took, s."""
        return self.until(lambda session: session.at_work, patience_s)

    def hover(self, patience_s: float = 20.0) -> float:
        """Let time pass until the fingers are up and the thermal sensor is heated; returns how long it took, s."""
        return self.until(lambda session: session.both_engaged and session.now.heater > 0.05, patience_s)

    @property
    def at_work(self) -> bool:
        """Whether the operator strokes and feels force, vibration and heat now."""
        if not self.truth or self.sim_operator.hand.segment.act != "stroke":
            return False
        return self.now.force_n > 0.2 and self.now.motor_mv > 0 and self.now.peltier != 0.0 and self.now.contact_n > 0.1

    def describe(self) -> str:
        """Where the session is, for a failed assertion."""
        return f"{super().describe()}; {self.truth[-1] if self.truth else ''}"

    def _observe(self, now_s: float) -> Truth:
        world, simulated = self.sim_remote.world, self.sim_operator
        return Truth(
            now_s,
            float(simulated.exoskeleton.force_n(now_s)[_INDEX]),
            self._tacttip.motor_mv,
            float(simulated.motors.rpm[_INDEX]),
            self._tacttip.drive,
            float(simulated.plates.plate_c[_INDEX]),
            float(world.force_n[_INDEX]),
            world.x_m,
            float(world.z_m[_INDEX]),
            self._thermal.drive,
            float(world.plate_c[_INDEX]),
        )


@contextmanager
def virtual_session(
    seed: int = 0,
    max_age_s: float = AGE_DEFAULT_S,
    recorders: Mapping[str, Recorder] | None = None,
    feed: MemoryFeed | None = None,
    *,
    patient_switch: bool = False,
    pressed_at_s: tuple[float, ...] = (),
) -> Iterator[VirtualSession]:
    """A session at virtual time 0 with a good network."""
    presses_s = pressed_at_s if patient_switch else None
    session = VirtualSession(seed, max_age_s, recorders or {}, feed, presses_s)
    try:
        yield session
    finally:
        session.close()
