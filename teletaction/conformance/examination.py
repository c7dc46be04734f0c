"""Test one device at one address, from the first duty to the last, and leave it neutral in every case."""

from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any

from common.buses.can_address import can_address
from common.buses.serial_messages import DeviceKind
from common.buses.serial_port import DeviceAbsent
from teletaction.conformance.checklist import Checklist, Driven, How, Trial, Tried, Unsafe, Verdict
from teletaction.conformance.cut_out import CUT_OUT, Heating
from teletaction.conformance.disturbed_module import DISTURBED
from teletaction.conformance.driven_module import DRIVEN
from teletaction.conformance.drives import Drives
from teletaction.conformance.every_module import MODULE
from teletaction.conformance.every_node import NODE
from teletaction.conformance.exoskeleton_node import EXOSKELETON
from teletaction.conformance.find_devices import require_interface
from teletaction.conformance.module_talk import ModuleTalk, PortEnd
from teletaction.conformance.motor import TACTTIP
from teletaction.conformance.node_on_trial import ExoskeletonOnTrial, TelemanipulatorOnTrial
from teletaction.conformance.node_talk import KINDS, BusEnd, NodeName, NodeTalk, name_of
from teletaction.conformance.sensor_modules import PATIENT_SWITCH, TEXTURE
from teletaction.conformance.telemanipulator_node import TELEMANIPULATOR

CHECKLISTS: tuple[Checklist[Any], ...] = (
    MODULE,
    DISTURBED,
    TEXTURE,
    PATIENT_SWITCH,
    DRIVEN,
    CUT_OUT,
    TACTTIP,
    NODE,
    EXOSKELETON,
    TELEMANIPULATOR,
)
"""All duties, in the order of docs/protocols.md."""


@dataclass(frozen=True, slots=True)
class OnTrial:
    """A device that was found, and its duties.

    Attributes:
        name: kind and serial number, or name of the node.
        trials: its duties.
        driven: the device as it is made neutral; None for a device without drives.
        warning: effect of `--exercise` and `--heat` on the device.
    """

    name: str
    trials: list[Trial]
    driven: Driven | None
    warning: dict[How, str]

    def only(self, numbers: Container[str]) -> "OnTrial":
        """Return the same device with these duties alone."""
        return replace(self, trials=[trial for trial in self.trials if trial[0].number in numbers])

    def tried(self, allowed: Container[How], report: Callable[[Tried], None]) -> list[Tried]:
        """Try the duties, report each at once, and leave a driven device neutral, also after an interruption.

        `allowed` are the kinds of trial that the user has agreed to.
        """
        results, stopped, driving = [], "", False
        try:
            for duty, device in self.trials:
                if stopped or duty.how not in allowed:
                    tried = Tried(duty, Verdict.NOT_TRIED, stopped or f"needs {duty.how}")
                else:
                    drives = duty.how is not How.LISTEN
                    driving = driving or drives
                    try:
                        tried = duty.tried_on(device)
                        if drives and self.driven is not None:
                            self.driven.settle()
                    except (Unsafe, DeviceAbsent) as danger:
                        if driving:
                            self._let_go()  # before the result is reported
                        stopped = f"stopped at {duty.number}: {danger}"
                        tried = Tried(duty, Verdict.FAIL, str(danger))
                report(tried)
                results.append(tried)
            return results
        finally:
            if driving:
                self._let_go()

    def _let_go(self) -> None:
        """Make the device neutral if it is still present, and wait until it has received the command.

        Closing a TCP connection with unread frames resets it, and the last command may then be lost.
        """
        if self.driven is not None:
            with suppress(DeviceAbsent, Unsafe):
                self.driven.settle()


def module_on_trial(talk: ModuleTalk) -> OnTrial:
    """Return a serial module with its duties."""
    name = talk.kind.name.lower().replace("_", " ")
    if talk.identity is not None:
        name += f" {talk.identity.serial}"
    trials = _each(MODULE, talk) + _each(DISTURBED, talk)
    if talk.kind is DeviceKind.TEXTURE_SENSOR:
        return OnTrial(name, trials + _each(TEXTURE, talk), None, {})
    if talk.kind is DeviceKind.PATIENT_SWITCH:
        return OnTrial(name, trials + _each(PATIENT_SWITCH, talk), None, {})
    drives = Drives(talk)
    trials += _each(DRIVEN, drives)
    warning = {
        How.EXERCISE: "drives its Peltier element with up to 300 thousandths for 1 s, heating and cooling",
        How.HEAT: "heats its plate until its own temperature limit acts at 42 C, at most to 43 C",
    }
    if drives.tacttip:
        trials += _each(TACTTIP, drives)
        warning[How.EXERCISE] += ", and its motor with up to 1 V"
    return OnTrial(name, trials + _each(CUT_OUT, Heating(drives)), drives, warning)


def node_on_trial(talk: NodeTalk) -> OnTrial:
    """Return a CAN node with its duties."""
    if talk.kind.name is NodeName.EXOSKELETON:
        exoskeleton = ExoskeletonOnTrial(talk)
        trials = _each(NODE, exoskeleton) + _each(EXOSKELETON, exoskeleton)
        return OnTrial(talk.kind.name, trials, exoskeleton, {How.EXERCISE: "pushes with 0.3 N on each finger"})
    robot = TelemanipulatorOnTrial(talk)
    trials = _each(NODE, robot) + _each(TELEMANIPULATOR, robot)
    moves = (
        "moves its fingers up by 1 mm and back, after down by up to 2 mm where there is no room above, "
        "and its hand by 1 mm along x and back"
    )
    return OnTrial(talk.kind.name, trials, robot, {How.EXERCISE: moves})


def _each(checklist: Checklist[Any], device: object) -> list[Trial]:
    return [(duty, device) for duty in checklist.duties]


@contextmanager
def opened(address: str, kind: DeviceKind | NodeName | None = None, finger: int | None = None) -> Iterator[OnTrial]:
    """Open an address and identify its device.

    Args:
        address: address of a serial device, or of a CAN bus: `socketcan:can0`, `socketcand://HOST:PORT/CHANNEL`.
        kind: expected kind of the device; None: the kind that it reports.
        finger: expected finger, 0..4; None: any.

    Raises:
        DeviceAbsent: no device, or a device that does not report its kind.
        ValueError: the kind or finger does not fit the address, or a site is running on the bus.
    """
    bus = can_address(address)
    if bus is None:
        if isinstance(kind, NodeName):
            raise ValueError(f"{address}: the {kind} is on CAN: socketcan:CHANNEL or socketcand://HOST:PORT/CHANNEL")
        port = PortEnd(address)
        try:
            yield module_on_trial(ModuleTalk(port, kind, finger))
        finally:
            port.close()
        return
    if isinstance(kind, DeviceKind):
        raise ValueError(f"{address}: a {kind.name.lower()} is a serial device, not on CAN")
    if finger is not None:
        raise ValueError(f"{address}: a CAN node serves all fingers")
    require_interface(bus)
    end = BusEnd(bus)
    try:
        yield node_on_trial(NodeTalk(end, KINDS[kind or name_of(end)]))
    finally:
        end.close()
