"""Run both sites of a session in one process, in lock step with their devices.

Lines, buses and link are real: devices are served over TCP, and CurveZMQ connects the sites. Time is virtual: a step of
2 ms begins as soon as the one before has ended, so nothing waits and nothing is late. A site ticks at its own rate, in
every step or in every second one.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from common.config.file import load_config, to_toml
from common.config.simulation_models import SimOperatorConfig, SimRemoteConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.link.keys import TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.link.local_control import LocalControlSocket
from common.recording.recorder import Recorder
from common.runtime.containment import Containment, MakeContainment
from common.timing.standstill import HostClock
from operator_site.devices.devices import OperatorDevices
from operator_site.session.remote_key import remote_public_key
from operator_site.site import OperatorSite, session_with
from operator_site.site_recording import SCHEMAS
from remote_site.devices.devices import RemoteDevices
from remote_site.site import RemoteSite
from remote_site.site_recording import open_recorder
from sim_sensors import operator_devices as sim_operator
from sim_sensors import remote_devices as sim_remote
from sim_sensors.ports.select_loop import SelectLoop

STEP_S = 0.002
_PATIENCE_S = 20.0
"""Real time in which devices must be found and both sites engaged, s."""
_FIRST_S = 1000.0
"""Virtual time of the first step, s."""


class SimulatedDevices:
    """The devices of both sites, served over TCP as the simulators serve them.

    Attributes:
        remote, operator: devices of each site.
    """

    def __init__(self, configs: Mapping[str, Path], now: Callable[[], float]) -> None:
        """Open everything.

        Args:
            configs: configuration files by the names of `teletaction.session.demo_files.prepare`.
            now: virtual time, s.

        Raises:
            ValueError: the scene, an address or the recording of a configuration is unusable.
        """
        remote = load_config(configs["sim-remote"], SimRemoteConfig)
        operator = load_config(configs["sim-operator"], SimOperatorConfig)
        self._sockets = {name: SelectLoop(now) for name in ("sim-operator", "sim-remote")}
        self.remote = sim_remote.RemoteDevices(remote, self._sockets["sim-remote"])
        try:
            self.operator = sim_operator.OperatorDevices(operator, self._sockets["sim-operator"])
        except ValueError:
            self.remote.close()
            raise

    def step(self, now_s: float) -> None:
        """Read the commands to the devices, advance by a step to `now_s`, and send the due reports."""
        self.advance("sim-operator", self.operator, now_s)
        self.advance("sim-remote", self.remote, now_s)

    def advance(
        self, name: str, devices: sim_operator.OperatorDevices | sim_remote.RemoteDevices, now_s: float
    ) -> None:
        """Advance the devices of one site by one step."""
        self._sockets[name].serve(0.0)
        devices.step(now_s)

    def close(self) -> None:
        """Release all addresses and finish the recordings."""
        self.remote.close()
        self.operator.close()


class NotEngaged(RuntimeError):
    """The sites did not find their devices or each other."""


class LockStep:
    """One session.

    Attributes:
        time_s: virtual time, s.
        remote, operator: the two sites.
    """

    remote: RemoteSite
    operator: OperatorSite

    def __init__(self) -> None:
        """Start without sites."""
        self.time_s = _FIRST_S
        self._steps = 0
        self._every: dict[str, int] = {}

    def now_s(self) -> float:
        """Return the virtual time, s."""
        return self.time_s

    def now_ns(self) -> int:
        """Return the virtual time, ns."""
        return round(self.time_s * 1e9)

    def step(self, devices: SimulatedDevices) -> None:
        """Advance to the next step; the sites' ticks follow."""
        self._steps += 1
        self.time_s = _FIRST_S + self._steps * STEP_S
        devices.step(self.time_s)

    def due(self) -> Iterator[tuple[str, RemoteSite | OperatorSite]]:
        """Yield the sites whose tick follows this step, with their names."""
        for name, site in (("remote", self.remote), ("operator", self.operator)):
            if self._steps % self._every[name] == 0:
                yield name, site

    def tick(self, devices: SimulatedDevices) -> None:
        """Advance to the next step and run the ticks of the sites that are due."""
        self.step(devices)
        for _, site in self.due():
            site.tick(self.now_ns())

    def open(self, remote: RemoteSite, operator: OperatorSite, remote_hz: float, operator_hz: float) -> None:
        """Set the sites and their tick rates, Hz; 1 / STEP_S is a multiple of each rate."""
        self.remote, self.operator = remote, operator
        self._every = {"remote": round(1.0 / remote_hz / STEP_S), "operator": round(1.0 / operator_hz / STEP_S)}

    def engage(self, devices: SimulatedDevices) -> None:
        """Step until both sites are engaged; raises NotEngaged when that takes too long."""
        deadline_s = time.monotonic() + _PATIENCE_S
        while not (self.operator.client.both_engaged and self.remote.server.both_engaged):
            if time.monotonic() > deadline_s:
                raise NotEngaged(f"not engaged within {_PATIENCE_S:g} s: {self.operator.figures()}")
            self.tick(devices)
            time.sleep(0.0005)  # threads open the devices, and handshakes take real time


@contextmanager
def sites(
    lockstep: LockStep, configs: Mapping[str, Path], containment: MakeContainment = Containment
) -> Iterator[LockStep]:
    """Open both sites of a session whose devices are served already, each with a recording and a desk.

    Args:
        lockstep: lock step that ticks the sites and provides their clock.
        configs: configuration files by the names of `teletaction.session.demo_files.prepare`.
        containment: makes each site's containment, which names the stages of its tick.
    """
    remote, operator = load_config(configs["remote"], RemoteConfig), load_config(configs["operator"], OperatorConfig)
    clock = HostClock(lockstep.now_ns)
    with ExitStack() as opened:
        keys = load_keys(remote.link.keys)
        remote_link = opened.enter_context(
            RemoteLink(remote.link.bind, remote.link.base_port, keys, TrustedKeys(remote.link.keys))
        )
        remote_devices = RemoteDevices(remote, clock)
        opened.callback(remote_devices.close)
        recorder = open_recorder(remote, {"configuration": to_toml(remote)})
        assert recorder is not None
        opened.enter_context(recorder)
        desk = opened.enter_context(LocalControlSocket(remote.desk_port, keys))
        remote_site = RemoteSite(
            remote, remote_link, remote_devices, recorder, desk, stamp_ns=lockstep.now_ns, containment=containment
        )
        keys = load_keys(operator.link.keys)
        operator_link = opened.enter_context(
            OperatorLink(operator.link.host, operator.link.base_port, keys, remote_public_key(operator.link))
        )
        operator_devices = OperatorDevices(operator, clock)
        opened.callback(operator_devices.close)
        assert operator.record is not None
        written = opened.enter_context(Recorder(operator.record, SCHEMAS, {"configuration": to_toml(operator)}))
        desk = opened.enter_context(LocalControlSocket(operator.desk_port, keys))
        operator_site = OperatorSite(
            operator,
            session_with(operator_link, operator, lockstep.now_ns),
            operator_devices,
            written,
            desk,
            containment=containment,
        )
        lockstep.open(remote_site, operator_site, remote.rate_hz, operator.rate_hz)
        yield lockstep
