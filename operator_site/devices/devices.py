"""Reads and writes all devices of the operator site. Only the gate's output is written."""

import math

from common.buses.ready_lines import ReadyLines
from common.buses.serial_device import SerialDevice
from common.buses.wiring import SYSTEM, Wiring
from common.config.site_models import OperatorConfig
from common.faults.fault import EXOSKELETON, Fault
from common.fingers import FINGERS
from common.limits import GAP_S
from common.timing.standstill import HostClock
from common.timing.tick_age import TickAge
from operator_site.devices.exoskeleton import Exoskeleton, Hand
from operator_site.devices.tacttip import TactTip
from operator_site.safety.gated_output import GatedOutput


class OperatorDevices:
    """Opens every device in the background; reading and writing never block."""

    def __init__(self, config: OperatorConfig, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the devices through `wiring`; `clock` gives the times of `read`."""
        clock = HostClock() if clock is None else clock
        self.exoskeleton = Exoskeleton(config.exoskeleton, config.fingers, clock, wiring)
        self.tacttips = {FINGERS.index(f): TactTip(f, address, clock, wiring) for f, address in config.tacttip.items()}
        self._witnesses: list[Exoskeleton | TactTip] = [self.exoskeleton, *self.tacttips.values()]
        self._ready = ReadyLines([self.exoskeleton.line, *self.lines()])
        self.tick = TickAge(clock, self._unread_s)

    def _unread_s(self) -> float:
        """Return the time that devices took to send the unread data, s."""
        if not self._ready.look() and self.exoskeleton.line.drained:
            return 0.0
        return max(device.unread_s for device in self._witnesses)

    def lines(self) -> list[SerialDevice]:
        """Every serial line."""
        return [module.line for module in self.tacttips.values()]

    def missing(self) -> str:
        """Return which device is missing and why; empty when none is."""
        if why := self._no_exoskeleton():
            return f"exoskeleton: {why}"
        for module in self.tacttips.values():
            if why := self._no_module(module):
                return f"{module.name}: {why}"
        return ""

    def _no_exoskeleton(self) -> str:
        """Return why the exoskeleton is missing; empty when it is not."""
        line = self.exoskeleton.line
        if not line.connected:
            return str(line.problem or "opening")
        here = self.tick.began_s - self.exoskeleton.hand.oldest_s <= GAP_S
        if not here:
            return f"CAN {line.address} is open, but no positions come"
        return "it reports, but its drives stay off" if self.exoskeleton.commands.deaf else ""

    def _no_module(self, module: TactTip) -> str:
        """Return why a module is missing; empty when it is not."""
        if not module.line.connected:
            return str(module.line.problem or "opening")
        if not self.tick.began_s - module.measured_s <= GAP_S:
            return "the line is open, but no reports come"
        return "it reports, but receives no commands" if module.commands.deaf else ""

    def problems(self) -> list[Exception]:
        """Return the reasons why devices are not open, of those that have failed at least once."""
        lines = [self.exoskeleton.line.problem, *(line.problem for line in self.lines())]
        return [problem for problem in lines if problem is not None]

    def read(self, t_s: float) -> Hand:
        """Read all devices; `tick` counts a standstill of the host that their reports show."""
        self.tick.begin(t_s)
        self._ready.look()
        stood_still_s = 0.0
        for module in self.tacttips.values():
            if module.line.readable is not False:
                module.read(t_s)
                stood_still_s = max(stood_still_s, module.stood_still_s)
        hand = self.exoskeleton.read(t_s, stood_still=stood_still_s > 0.0)
        self.tick.stood_still(max(stood_still_s, self.exoskeleton.stood_still_s))
        return hand

    @property
    def pushes(self) -> bool:
        """Whether the exoskeleton reports that its drives are on; else no force acts, whatever is commanded."""
        pushing = self.exoskeleton.pushing
        return pushing.enabled and self.tick.began_s - pushing.reported_s <= GAP_S

    def plates(self, t_s: float) -> tuple[list[float], list[float]]:
        """Return each plate's last temperature, C, NaN where it is implausible, and its age, s."""
        plate_c, age_s = [math.nan] * len(FINGERS), [math.inf] * len(FINGERS)
        for finger, module in self.tacttips.items():
            plate_c[finger], age_s[finger] = module.plate_c, t_s - module.measured_s
        return plate_c, age_s

    def write(self, t_s: float, output: GatedOutput, engaged: bool) -> None:
        """Send the gate's output, unless the tick that read the devices is too old."""
        if self.tick.in_time():
            self.exoskeleton.push(t_s, output.force_n, engaged)
        for finger, module in self.tacttips.items():
            if not module.may_send(t_s, output.motor_rpm[finger]):
                continue
            if not self.tick.in_time():
                return
            module.drive(t_s, output.motor_rpm[finger], output.peltier_drive[finger])

    def unconfirmed(self, since_s: float) -> dict[str, str]:
        """Return why each device's outputs may not be off since `since_s`, s; empty where its report says so."""
        found = {"exoskeleton": self.exoskeleton.unconfirmed(since_s)}
        for module in self.tacttips.values():
            found[module.name] = module.unconfirmed(since_s)
        return found

    def faults(self) -> list[Fault]:
        """Return the faults of all devices."""
        now_s = self.tick.began_s
        found = [fault._replace(device=EXOSKELETON) for fault in self.exoskeleton.faults(now_s)]
        for module in self.tacttips.values():
            if module.faults and now_s - module.measured_s <= GAP_S:
                found += module.faults
        return found

    def figures(self) -> dict[str, object]:
        """Return the figures of each device for the status file."""
        return {
            "exoskeleton": {**self.exoskeleton.line.figures(), "missing": self._no_exoskeleton()},
            **{
                module.name: {**module.line.figures(), "missing": self._no_module(module)}
                for module in self.tacttips.values()
            },
        }

    def close(self) -> None:
        """Close every device; its own time-out turns its outputs off."""
        self.exoskeleton.line.close()
        for line in self.lines():
            line.close()
