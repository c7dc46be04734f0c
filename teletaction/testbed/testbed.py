"""Run a whole session in one process on a virtual clock: both sites, all simulated devices, and the network.

Lines, buses and the link are in memory. Nothing waits and nothing is late: the same seed gives the same session.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from common.config.file import load_config
from common.config.simulation_models import SimOperatorConfig, SimRemoteConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.recording.recorder import Recorder
from common.timing.standstill import HostClock
from common.timing.timeouts import NOTICE_S
from common.wire.packets import LinkState
from operator_site.devices.devices import OperatorDevices
from operator_site.session.console_feed import ConsoleFeed
from operator_site.site import OperatorSite, session_with
from remote_site.devices.devices import RemoteDevices
from remote_site.site import RemoteSite
from sim_sensors import operator_devices as sim_operator
from sim_sensors import remote_devices as sim_remote
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.simulation_loop import MOST_STEPS, STEP_S
from teletaction.testbed.memory_desk import MemoryDesk
from teletaction.testbed.memory_lines import MemoryBus, MemoryLine
from teletaction.testbed.memory_wiring import MemoryWiring
from teletaction.testbed.network import Network, OperatorEnd, RemoteEnd
from teletaction.testbed.site_clock import SiteClock

COARSE_STEP_S = 0.010
"""Longest step of the simulated devices, s."""
FINE_S = 1.0
"""Time after a site stops by which its outputs no longer change, s."""
SITES = ("remote", "operator")


@dataclass(frozen=True, slots=True)
class SessionConfigs:
    """Configurations of a session. Addresses serve only as names and are not opened."""

    sim_remote: SimRemoteConfig
    sim_operator: SimOperatorConfig
    remote: RemoteConfig
    operator: OperatorConfig

    @classmethod
    def read(cls, files: Mapping[str, Path]) -> Self:
        """Read files by the names of `teletaction.session.demo_files.prepare`; fault ports are left out."""
        without = {"fault_port": None}
        return cls(
            load_config(files["sim-remote"], SimRemoteConfig).model_copy(update=without),
            load_config(files["sim-operator"], SimOperatorConfig).model_copy(update=without),
            load_config(files["remote"], RemoteConfig),
            load_config(files["operator"], OperatorConfig),
        )


@dataclass(slots=True)
class _Turns:
    """Schedule of a process's turns."""

    every_s: float
    due_s: float = 0.0
    stopped: bool = False
    """Whether the process stands still: it is stopped, or it sleeps in a tick."""

    def due(self, now_s: float) -> bool:
        """Return whether the process has its turn now."""
        if self.stopped or now_s < self.due_s:
            return False
        self.due_s = now_s + self.every_s - 0.5 * STEP_S
        return True


@dataclass(slots=True)
class _Simulated:
    """The process of a site's simulated devices, with their ends of lines and buses."""

    devices: sim_remote.RemoteDevices | sim_operator.OperatorDevices
    ends: list[MemoryLine | MemoryBus]

    def stop(self) -> None:
        """Stop the process."""
        for end in self.ends:
            end.hold()

    def resume(self, time_s: float, missed: int) -> None:
        """Resume: read the waiting data, and make up for as many missed steps as a real process does."""
        for end in self.ends:
            end.release()
        for number in reversed(range(min(missed, MOST_STEPS))):
            self.devices.step(time_s - number * STEP_S)


@dataclass(frozen=True, slots=True)
class Extras:
    """Optional parts of a session beside its configurations.

    Attributes:
        remote_clock, operator_clock: clocks of the sites' hosts.
        recorders: recorders of the sites by name; a site without one records nothing.
        feed: feed of the operator's site to consoles; None: consoles receive nothing.
    """

    remote_clock: SiteClock = field(default_factory=SiteClock)
    operator_clock: SiteClock = field(default_factory=SiteClock)
    recorders: Mapping[str, Recorder] = field(default_factory=dict)
    feed: ConsoleFeed | None = None


class Testbed:
    """One session; `tick` advances all of it by a step.

    Attributes:
        time_s: virtual time, s; the first step is at 2 ms.
        step_s: length of a step, s.
        network: the link between the sites, which can be impaired.
        wiring: lines and buses.
        remote, operator: the sites.
        sim_remote, sim_operator: their simulated devices.
        remote_clock, operator_clock: clocks of the sites' hosts.
        remote_host, operator_host: these clocks as read by the sites.
        desks: desks of both sites by name.
        beside: other processes, such as a console; called at the end of each step.
    """

    __test__ = False

    def __init__(self, configs: SessionConfigs, seed: int, extras: Extras | None = None) -> None:
        """Begin at virtual time 0, with a good network.

        Args:
            configs: configurations of sites and simulated devices.
            seed: seed of the network's randomness.
            extras: clocks, recorders and a feed.

        Raises:
            ValueError: a configuration is unusable.
        """
        extras = extras or Extras()
        self.time_s = 0.0
        self.step_s = STEP_S
        self.network = Network(seed)
        self.wiring = MemoryWiring(lambda: self.time_s)
        self.remote_clock, self.operator_clock = extras.remote_clock, extras.operator_clock
        self.remote_host = HostClock(lambda: self.remote_clock.now_ns(self.time_s))
        self.operator_host = HostClock(lambda: self.operator_clock.now_ns(self.time_s))
        loop = SelectLoop(lambda: self.time_s)
        self.sim_remote = sim_remote.RemoteDevices(configs.sim_remote, loop, self.wiring)
        of_remote = self.wiring.ends
        self.sim_operator = sim_operator.OperatorDevices(configs.sim_operator, loop, self.wiring)
        self._simulated = {
            "sim-remote": _Simulated(self.sim_remote, of_remote),
            "sim-operator": _Simulated(self.sim_operator, [end for end in self.wiring.ends if end not in of_remote]),
        }
        self.beside: list[Callable[[], None]] = []
        self.desks = {site: MemoryDesk() for site in SITES}
        self._remote_devices = RemoteDevices(configs.remote, self.remote_host, self.wiring)
        self._operator_devices = OperatorDevices(configs.operator, self.operator_host, self.wiring)
        self.remote = RemoteSite(
            configs.remote,
            RemoteEnd(self.network),
            self._remote_devices,
            extras.recorders.get("remote"),
            self.desks["remote"],
            self.remote_host.now_ns,
        )
        self._client = session_with(OperatorEnd(self.network), configs.operator, self.operator_host.now_ns)
        self.operator = OperatorSite(
            configs.operator,
            self._client,
            self._operator_devices,
            extras.recorders.get("operator"),
            self.desks["operator"],
            extras.feed,
        )
        self._turns = {
            "sim-remote": _Turns(STEP_S),
            "sim-operator": _Turns(STEP_S),
            "remote": _Turns(1.0 / configs.remote.rate_hz),
            "operator": _Turns(1.0 / configs.operator.rate_hz),
        }
        self._figures = _Turns(NOTICE_S, stopped=extras.feed is None)

    def tick(self) -> None:
        """Advance by one step: physics and devices, then the sites whose tick is due."""
        self.time_s = self.network.now_s = now_s = self.time_s + self.step_s
        turns = self._turns
        if turns["sim-remote"].due(now_s):
            self.sim_remote.step(now_s)
        if turns["sim-operator"].due(now_s):
            self.sim_operator.step(now_s)
        # Time passes while a site is stopped in its tick, so later calls read their clocks again.
        if turns["remote"].due(now_s):
            self.remote.tick(self.remote_host.now_ns())
        if turns["operator"].due(now_s):
            now_ns = self.operator_host.now_ns()
            self.operator.tick(now_ns)
            if self._figures.due(now_s):
                self.operator.publish(now_ns, self.operator.figures())
        for step in [*self.beside]:
            step()

    def run(self, seconds: float) -> None:
        """Advance by `seconds`."""
        for _ in range(round(seconds / self.step_s)):
            self.tick()

    def run_coarsely(self, seconds: float) -> None:
        """Advance by `seconds` at 100 Hz, five times as fast, for long times without expected events."""
        with self.stepping(COARSE_STEP_S):
            self.run(seconds)

    @contextmanager
    def stepping(self, step_s: float) -> Iterator[None]:
        """Advance in steps of another length, s, until the context ends."""
        before_s = self.step_s
        self.step_s = self.sim_remote.step_s = self.sim_operator.step_s = step_s
        try:
            yield
        finally:
            self.step_s = self.sim_remote.step_s = self.sim_operator.step_s = before_s

    def until(self, reached: Callable[[Self], object], patience_s: float) -> float:
        """Advance until `reached` is true; return the time that it took, s.

        Raises:
            AssertionError: it did not become true within `patience_s`.
        """
        start_s = self.time_s
        while not reached(self):
            waited_s = self.time_s - start_s
            if waited_s >= patience_s:
                raise AssertionError(f"not reached in {waited_s:.1f} s: {self.describe()}")
            self.tick()
        return self.time_s - start_s

    def stop(self, process: str, seconds: float) -> None:
        """Stop a site or its simulated devices between two ticks, as SIGSTOP does; long times pass coarsely.

        Args:
            process: `remote`, `operator`, `sim-remote` or `sim-operator`.
            seconds: duration of the stop, s.
        """
        turns, simulated = self._turns[process], self._simulated.get(process)
        turns.stopped = True
        if simulated is not None:
            simulated.stop()
        fine_s = min(seconds, FINE_S)
        self.run(fine_s)
        self.run_coarsely(seconds - fine_s)
        turns.stopped = False
        if simulated is not None:
            simulated.resume(self.time_s, round(seconds / STEP_S))

    def suspend(self, site: str, seconds: float) -> None:
        """Stop a site and its host's clock between two ticks, like a paused virtual machine."""
        clock = self._clock(site)
        clock.stopped_s = self.time_s
        self.stop(site, seconds)
        clock.run_on(self.time_s)

    def stop_in_tick(self, site: str, seconds: float, *, with_clock: bool = False, before_read: bool = False) -> None:
        """Stop a site in its next tick, before or after it reads its devices, optionally with its clock."""

        devices: Any = self._remote_devices if site == "remote" else self._operator_devices

        def read_once(*given: Any) -> Any:
            del devices.read  # later readings are the devices' own again
            reading = None if before_read else devices.read(*given)
            if with_clock:
                self.suspend(site, seconds)
            else:
                self.stop(site, seconds)
            return devices.read(*given) if before_read else reading

        devices.read = read_once
        self._turns[site].due_s = self.time_s
        self.tick()

    def _clock(self, site: str) -> SiteClock:
        return self.remote_clock if site == "remote" else self.operator_clock

    def break_device(self, fault: str) -> None:
        """Begin a fault: `remote: FAULT` or `operator: FAULT`, with a command of `sim_sensors.faults.faults`."""
        side, _, command = fault.partition(": ")
        faults = {"remote": self.sim_remote.faults, "operator": self.sim_operator.faults}
        faults[side].apply(command)

    def mend_devices(self) -> None:
        """End every fault of every device."""
        for simulation in (self.sim_remote, self.sim_operator):
            simulation.faults.apply("mend")

    def ask_desk(self, site: str, verb: str) -> dict[str, Any]:
        """Send a request at the desk of a site, as a person there would; return the answer when it comes.

        Raises:
            Refused: the site refuses the request; the text gives the reason.
            TimeoutError: the site does not answer within a second.
        """
        answer = self.desks[site].ask(verb)
        begun_s = self.time_s
        while not answer.done():
            if self.time_s > begun_s + 1.0:
                raise TimeoutError(f"{site}: no answer to {verb}")
            self.tick()
        return answer.result()

    def ask(self, verb: str) -> None:
        """Send a request of the operator to the remote site."""
        self._client.request(verb, self.operator_host.now_ns(), {})

    def emergency_stop(self) -> None:
        """Trigger the operator's emergency stop."""
        self.operator.client.stop(self.operator_host.now_ns())

    def clear_faults(self) -> None:
        """Clear a latched fault on either site, as a person does."""
        client = self.operator.client
        if client.remote_fault or client.session.state is LinkState.FAULT:
            client.clear(self.operator_host.now_ns())

    def engage(self) -> None:
        """Request engagement as the operator."""
        self.operator.client.want_engaged = True

    @property
    def latched(self) -> tuple[bool, bool]:
        """Whether a fault is latched at the remote site, and at the operator site."""
        sessions = self.remote.server.session, self.operator.client.session
        return sessions[0].state is LinkState.FAULT, sessions[1].state is LinkState.FAULT

    @property
    def both_engaged(self) -> bool:
        """Whether both sites report that outputs may act."""
        return self.remote.server.both_engaged and self.operator.client.both_engaged

    def describe(self) -> str:
        """Return a description of the session's state, for a failed assertion."""
        server, client = self.remote.server, self.operator.client
        return (
            f"at {self.time_s:.3f} s; remote {server.session}, refused {dict(server.acceptance.refused)}; "
            f"operator {client.session}, refused {dict(client.acceptance.refused)}, {client.refusal!r}"
        )

    def close(self) -> None:
        """Close the sites' devices, and finish the recordings of the simulated devices."""
        self._remote_devices.close()
        self._operator_devices.close()
        self.sim_remote.close()
        self.sim_operator.close()
