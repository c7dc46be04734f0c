"""A whole session in one process on a virtual clock: both sites, all emulators, their physics, and the network."""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import pytest

import sim_sensors.sim_operator
import sim_sensors.sim_remote
from common.fingers import FINGERS
from common.limits import AGE_DEFAULT_S
from common.link import OperatorLink, RemoteLink
from common.packets import LinkState
from common.standstill import HostClock
from operator_site.devices import OperatorDevices
from operator_site.site import OperatorSite, session_with
from remote_site.devices import RemoteDevices
from remote_site.site import RemoteSite
from sim_sensors.select_loop import SelectLoop
from tests.virtual import configurations
from tests.virtual.configurations import FINGER
from tests.virtual.network import Network, OperatorEnd, RemoteEnd
from tests.virtual.wires import Wires

TICK_S = 0.002
COARSE_TICK_S = 0.010
FINE_S = 1.0
"""A stopped site: what happens to its outputs has happened by then."""
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


@dataclass(slots=True)
class SiteClock:
    """A host's own clock: virtual time with an offset of its own, and a drift in s/s.

    Attributes:
        stopped_s: virtual time at which it stopped; None while it runs.
    """

    offset_s: float
    drift: float = 0.0
    stopped_s: float | None = None

    def now_ns(self, time_s: float) -> int:
        """What this clock says at a virtual time."""
        shown_s = time_s if self.stopped_s is None else self.stopped_s
        return round((shown_s * (1.0 + self.drift) + self.offset_s) * 1e9)

    def run_on(self, time_s: float) -> None:
        """Run again from where it stopped, at a virtual time."""
        if self.stopped_s is not None:
            self.offset_s -= (time_s - self.stopped_s) * (1.0 + self.drift)
            self.stopped_s = None


class VirtualSession:
    """One operator, one remote site, one finger each; `tick` advances all of it.

    Attributes:
        time_s: virtual time.
        truth: what was at the actuators, one entry a tick.
        watch: called after every tick with its truth; a check that must always hold raises here.
    """

    def __init__(self, wires: Callable[[Callable[[], float]], Wires], seed: int, max_age_s: float) -> None:
        self.time_s = 0.0
        self.tick_s = TICK_S
        self.truth: list[Truth] = []
        self.watch: list[Callable[[VirtualSession, Truth], None]] = []
        self.network = Network(seed)
        self.wires = wires(lambda: self.time_s)
        self.remote_clock, self.operator_clock = SiteClock(7_200.123), SiteClock(100.456)
        self.remote_host = HostClock(lambda: self.remote_clock.now_ns(self.time_s))
        self.operator_host = HostClock(lambda: self.operator_clock.now_ns(self.time_s))
        loop = SelectLoop(lambda: self.time_s)
        self.sim_remote = sim_sensors.sim_remote.RemoteDevices(configurations.sim_remote(seed), loop)
        self.sim_operator = sim_sensors.sim_operator.OperatorDevices(configurations.sim_operator(seed), loop)
        remote, operator = configurations.remote(max_age_s), configurations.operator(max_age_s)
        self.remote = RemoteSite(
            remote,
            cast(RemoteLink, RemoteEnd(self.network)),
            RemoteDevices(remote, self.remote_host),
        )
        self.operator = OperatorSite(
            operator,
            session_with(cast(OperatorLink, OperatorEnd(self.network)), operator),
            OperatorDevices(operator, self.operator_host),
        )
        self._remote_every_s, self._remote_due_s = 1.0 / remote.rate_hz, 0.0
        self._stopped: RemoteSite | OperatorSite | None = None
        self._tacttip = self.sim_operator.modules[FINGER]
        self._thermal = self.sim_remote.thermal[FINGER]

    @property
    def now(self) -> Truth:
        """What is at the actuators now."""
        return self.truth[-1]

    def tick(self) -> None:
        """Let one tick pass: physics and devices, then both sites."""
        self.time_s = self.network.now_s = now_s = self.time_s + self.tick_s
        self.sim_remote.step(now_s)
        self.sim_operator.step(now_s)
        # A site that is stopped in its tick lets time pass: what follows begins later than this tick did.
        if self._stopped is not self.remote and now_s >= self._remote_due_s:
            self._remote_due_s = now_s + self._remote_every_s - 0.5 * TICK_S
            self.remote.tick(self.remote_host.now_ns())
        if self._stopped is not self.operator:
            self.operator.tick(self.operator_host.now_ns())
        truth = self._observe(self.time_s)
        self.truth.append(truth)
        for check in self.watch:
            check(self, truth)

    def stop_site(
        self, side: str, seconds: float, *, in_tick: bool, with_clock: bool = False, before_read: bool = False
    ) -> None:
        """Stop `remote` or `operator` for a time: between two ticks, or in a tick, mostly after it has read.

        A process is stopped by SIGSTOP, a host by a suspend: its clock counts that time. `with_clock`, the clock stops
        as well, as in a virtual machine that is paused. Long times pass coarsely.
        """
        site: RemoteSite | OperatorSite = self.remote if side == "remote" else self.operator
        clock = self.remote_clock if side == "remote" else self.operator_clock

        def sleep() -> None:
            self._stopped = site
            if with_clock:
                clock.stopped_s = self.time_s
            fine_s = min(seconds, FINE_S)
            self.run(fine_s)
            self.run_coarsely(seconds - fine_s)
            clock.run_on(self.time_s)
            self._stopped = None

        if not in_tick:
            sleep()
            return
        with pytest.MonkeyPatch.context() as patch:
            read = site._devices.read

            def read_and_sleep(*given: Any) -> object:
                patch.undo()
                if before_read:
                    sleep()
                found = read(*given)
                if not before_read:
                    sleep()
                return found

            patch.setattr(site._devices, "read", read_and_sleep)
            self.tick()

    def break_device(self, fault: str) -> None:
        """Begin a fault: `remote: FAULT` or `operator: FAULT`, in the words of `sim_sensors.faults`."""
        side, _, command = fault.partition(": ")
        faults = {"remote": self.sim_remote.faults, "operator": self.sim_operator.faults}
        faults[side].apply(command)

    def mend_devices(self) -> None:
        """End every fault of every device."""
        for simulation in (self.sim_remote, self.sim_operator):
            simulation.faults.apply("mend")

    def ask(self, verb: str) -> None:
        """The operator asks the remote site for something."""
        self.operator.client.request(verb, self._operator_ns, {})

    def stop(self) -> None:
        """The operator hits the emergency stop."""
        self.operator.client.stop(self._operator_ns, "emergency stop by the operator")

    def clear_faults(self) -> None:
        """A person clears whatever fault is latched on either site."""
        client = self.operator.client
        if client.remote_fault or client.session.state is LinkState.FAULT:
            client.clear(self._operator_ns)

    def engage(self) -> None:
        """The operator wants to work."""
        self.operator.client.want_engaged = True

    @property
    def disobeyed(self) -> bool:
        """Whether the telemanipulator's servos are broken: where it goes is in nobody's hand."""
        return any(fault.startswith("disobey") for fault in self.sim_remote.faults.in_force)

    @property
    def latched(self) -> tuple[bool, bool]:
        """Whether a fault is latched at the remote site, and at the operator's."""
        sessions = self.remote.server.session, self.operator.client.session
        return sessions[0].state is LinkState.FAULT, sessions[1].state is LinkState.FAULT

    @property
    def _operator_ns(self) -> int:
        return self.operator_host.now_ns()

    def run(self, seconds: float) -> list[Truth]:
        """Let time pass; returns what was at the actuators during it."""
        first = len(self.truth)
        for _ in range(round(seconds / self.tick_s)):
            self.tick()
        return self.truth[first:]

    def run_coarsely(self, seconds: float) -> list[Truth]:
        """The same at 100 Hz, five times as fast: for long times in which nothing should happen."""
        with pytest.MonkeyPatch.context() as patch:
            for simulation in (sim_sensors.sim_remote, sim_sensors.sim_operator):
                patch.setattr(simulation, "STEP_S", COARSE_TICK_S)
            self.tick_s = COARSE_TICK_S
            found = self.run(seconds)
            self.tick_s = TICK_S
        return found

    def until(self, reached: Callable[["VirtualSession"], object], patience_s: float) -> float:
        """Let time pass until something is reached; returns how long it took, s.

        Raises:
            AssertionError: it was not within `patience_s`.
        """
        start_s = self.time_s
        while not reached(self):
            waited_s = self.time_s - start_s
            assert waited_s < patience_s, f"not reached in {waited_s:.1f} s: {self.describe()}"
            self.tick()
        return self.time_s - start_s

    def work(self, patience_s: float = 20.0) -> float:
        """Let time pass until a stroke is felt that lasts three seconds more; returns how long it took, s."""
        return self.until(lambda session: session.at_work and session.sim_operator.hand.x_m < _EARLY_M, patience_s)

    def hover(self, patience_s: float = 20.0) -> float:
        """Let time pass until the fingers are up and the thermal sensor is heated; returns how long it took, s."""
        return self.until(lambda session: session.both_engaged and session.now.heater > 0.05, patience_s)

    @property
    def at_work(self) -> bool:
        """Whether the operator strokes and feels force, vibration and heat now."""
        if not self.truth or self.sim_operator.hand.segment.act != "stroke":
            return False
        return self.now.force_n > 0.2 and self.now.motor_mv > 0 and self.now.peltier != 0.0 and self.now.contact_n > 0.1

    @property
    def both_engaged(self) -> bool:
        """Whether both sites say that outputs may act."""
        return self.remote.server.both_engaged and self.operator.client.both_engaged

    def describe(self) -> str:
        """Where the session is, for a failed assertion."""
        server, client = self.remote.server, self.operator.client
        return (
            f"at {self.time_s:.3f} s; remote {server.session}, refused {dict(server.acceptance.refused)}; "
            f"operator {client.session}, refused {dict(client.acceptance.refused)}, {client.refusal!r}; "
            f"{self.truth[-1] if self.truth else ''}"
        )

    def close(self) -> None:
        """Close what was opened."""
        self.sim_remote.close()
        self.sim_operator.close()

    def _observe(self, now_s: float) -> Truth:
        world, sim_operator = self.sim_remote.world, self.sim_operator
        return Truth(
            now_s,
            float(sim_operator.exoskeleton.force_n(now_s)[_INDEX]),
            self._tacttip.motor_mv,
            float(sim_operator.motors.rpm[_INDEX]),
            self._tacttip.peltier_drive,
            float(sim_operator.plates.plate_c[_INDEX]),
            float(world.force_n[_INDEX]),
            world.x_m,
            float(world.z_m[_INDEX]),
            self._thermal.drive,
            float(world.plate_c[_INDEX]),
        )


@contextmanager
def virtual_session(seed: int = 0, max_age_s: float = AGE_DEFAULT_S) -> Iterator[VirtualSession]:
    """A session at virtual time 0 with a good network."""
    with ExitStack() as opened:
        null = opened.enter_context(open(os.devnull, "wb"))
        patch = opened.enter_context(pytest.MonkeyPatch.context())

        def lay(now: Callable[[], float]) -> Wires:
            wires = Wires(now, null.fileno())
            wires.lay(patch)
            return wires

        session = VirtualSession(lay, seed, max_age_s)
        opened.callback(session.close)
        yield session
