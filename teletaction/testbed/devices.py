"""Step all simulated devices of a session together."""

from collections.abc import Callable, Mapping
from pathlib import Path

from common.config import SimOperatorConfig, SimRemoteConfig, load_config
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.remote_devices import RemoteDevices


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
        self._sockets = {name: SelectLoop(now) for name in ("sim-operator", "sim-remote")}
        self.remote = RemoteDevices(load_config(configs["sim-remote"], SimRemoteConfig), self._sockets["sim-remote"])
        try:
            self.operator = OperatorDevices(
                load_config(configs["sim-operator"], SimOperatorConfig), self._sockets["sim-operator"]
            )
        except ValueError:
            self.remote.close()
            raise

    def step(self, now_s: float) -> None:
        """Read the commands to the devices, advance by a step to `now_s`, and send the due reports."""
        self.advance("sim-operator", self.operator, now_s)
        self.advance("sim-remote", self.remote, now_s)

    def advance(self, name: str, devices: OperatorDevices | RemoteDevices, now_s: float) -> None:
        """Advance the devices of one site by one step."""
        self._sockets[name].serve(0.0)
        devices.step(now_s)

    def close(self) -> None:
        """Release all addresses and finish the recordings."""
        self.remote.close()
        self.operator.close()
