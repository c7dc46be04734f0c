"""Faults that may occur in a session, and their required outcomes: the table that the fault matrix is judged by."""

import re
from dataclasses import dataclass, replace
from enum import Enum

from common.limits import GAP_S, SWITCH_LOST_S, SWITCH_SILENCE_S


class Outcome(Enum):
    """Effect of a fault on a session."""

    CONTINUES = "continues"
    """The finger keeps feeling force; at most what depends on the failed part is neutral."""
    RESUMES = "safe and resumes"
    """Everything is neutral within the hold times, and works again by itself after the fault."""
    LATCHED = "latched"
    """Everything is neutral until a person clears the fault and engages again."""


class Actuator(Enum):
    """Actuators that can reach a finger or a patient."""

    FORCE = "force"
    MOTOR = "motor"
    PELTIER = "Peltier"
    HEATER = "heater"
    HAND = "remote hand"


AT_FINGERS = frozenset({Actuator.FORCE, Actuator.MOTOR, Actuator.PELTIER})
AT_PATIENT = frozenset({Actuator.HEATER, Actuator.HAND})
ALL = AT_FINGERS | AT_PATIENT


@dataclass(frozen=True, slots=True)
class Fault:
    """One row of the table.

    Attributes:
        name: description of the fault.
        where: process into which the fault is injected.
        begin: command for its fault port (`sim-remote`, `sim-operator`, `network`); `kill`, `stop` or `slow` for a
            process; `burn` for the machine; `full` for the disk.
        expected: required outcome.
        neutral: actuators that must be neutral within the hold times during the fault.
        finger: finger whose force, motor, Peltier and heater count; all by default.
        seconds: duration of the fault.
        mend: command that ends it; empty when it ends by itself, after `seconds`.
        noticed_s: time until a site can know that a device or the other site is silent, s. Hold times count from there.
        later_s: longest time until the latch, s, of a fault that is detected by its effect. Hold times count from the
            latch.
        network: command for the network just before the fault; empty for none. The network is mended with the fault.
        leaves: whether the remote fingers must leave the patient as after the patient's stop.
    """

    name: str
    where: str
    begin: str
    expected: Outcome
    neutral: frozenset[Actuator] = ALL
    finger: str | None = None
    seconds: float = 2.0
    mend: str = ""
    noticed_s: float = 0.0
    later_s: float = 0.0
    network: str = ""
    leaves: bool = False

    @property
    def key(self) -> str:
        """Identifier of the fault, unique in the table."""
        begin = f"{self.begin} {self.seconds:g} s" if self.begin == "stop" else self.begin
        return "-".join(filter(None, (self.where, begin, self.network))).replace(" ", "-").replace("_", "-")


STROKING, FREE = "middle", "index"
"""The finger that strokes an object, and its neighbour in the air, whose sensor's heater works."""

_CONTINUES, _RESUMES, _LATCHED = Outcome.CONTINUES, Outcome.RESUMES, Outcome.LATCHED
_NONE: frozenset[Actuator] = frozenset()
_MOTOR, _PELTIER, _HEATER = (frozenset({each}) for each in (Actuator.MOTOR, Actuator.PELTIER, Actuator.HEATER))
_WITHOUT_PLACE = frozenset({Actuator.FORCE, Actuator.MOTOR}) | AT_PATIENT
"""Actuators that need a finger's position. Without the telemanipulator's report of it, a plate still displays a finger
in the air."""
_SILENT = GAP_S
"""Time after which a device is known to be silent, s."""
_VALUE = re.compile(r" (open|short|frozen|cut|saturated|glitch|stuck|biased|drift|gone|counter \S+|crc \S+|\d+)$")
"""Value at the end of a device fault's command."""


def _mend(begin: str) -> str:
    """Return the command that ends a device fault; it has no value."""
    return f"mend {_VALUE.sub('', begin)}"


def _for_a_while(
    name: str,
    where: str,
    begin: str,
    expected: Outcome,
    neutral: frozenset[Actuator] = _NONE,
    finger: str | None = None,
    noticed_s: float = _SILENT,
) -> Fault:
    """A device fault that is mended after 2 s."""
    return Fault(name, where, begin, expected, neutral, finger=finger, mend=_mend(begin), noticed_s=noticed_s)


def _found(name: str, where: str, begin: str, later_s: float, neutral: frozenset[Actuator] = ALL) -> Fault:
    """A device fault that is detected by its effect, and latched."""
    return Fault(name, where, begin, _LATCHED, neutral, seconds=0.0, mend=_mend(begin), later_s=later_s)


NETWORK_FAULTS = (
    # These come first: an interrupted press is felt more weakly until the finger lifts (decision 18).
    Fault("delay 20 ± 5 ms", "network", "delay 20 5", _CONTINUES, _NONE, mend="clear"),
    Fault("delay 100 ± 20 ms", "network", "delay 100 20", _CONTINUES, _NONE, mend="clear"),
    Fault("partition 1 s", "network", "partition 1", _RESUMES, seconds=1.0),
    Fault("partition 10 s", "network", "partition 10", _RESUMES, seconds=10.0),
    Fault("stall 3 s, then a burst", "network", "stall 3", _RESUMES, seconds=3.0),
    # Dead connections are dropped after 2 s, and new ones get through. Until then outputs have to be neutral.
    Fault("half-open TCP", "network", "half_open 5", _RESUMES, seconds=1.5),
    Fault("way to the remote site cut, 2 s", "network", "partition 2 to_remote", _RESUMES, AT_PATIENT),
    Fault("way to the operator's site cut, 2 s", "network", "partition 2 to_operator", _RESUMES),
    Fault("TCP connections reset", "network", "cut", _RESUMES, _NONE, seconds=0.0),
    Fault("delay 400 ± 20 ms, age limit 150 ms", "network", "delay 400 20", _RESUMES, ALL, None, 4.0, "clear", 0.1),
)
_REMOTE, _OPERATOR = "sim-remote", "sim-operator"
DEVICE_FAULTS = (
    _for_a_while("texture sensor's cable pulled", _REMOTE, f"unplug {STROKING} texture", _CONTINUES, _MOTOR),
    _for_a_while("thermal sensor's cable pulled", _REMOTE, f"unplug {STROKING} thermal", _CONTINUES),
    _for_a_while(
        "TactTip's cable pulled",
        _OPERATOR,
        f"unplug {STROKING} tacttip",
        _CONTINUES,
        _MOTOR | _PELTIER,
        finger=STROKING,
        noticed_s=0.0,
    ),
    _for_a_while("telemanipulator's CAN cable pulled", _REMOTE, "unplug can", _RESUMES, _WITHOUT_PLACE),
    _for_a_while("exoskeleton's CAN cable pulled", _OPERATOR, "unplug can", _RESUMES, ALL),
    _for_a_while("telemanipulator silent", _REMOTE, "silence can", _RESUMES, _WITHOUT_PLACE),
    _for_a_while("exoskeleton silent", _OPERATOR, "silence can", _RESUMES, ALL),
    _found("telemanipulator's bus off", _REMOTE, "bus_off", 0.1),
    _found("exoskeleton's bus off", _OPERATOR, "bus_off", 0.1),
    *(
        _found(f"{device}: {words} damaged", where, f"damage can {damage}", 0.2)
        for device, where in (("telemanipulator", _REMOTE), ("exoskeleton", _OPERATOR))
        for words, damage in (("every second counter", "counter 0.5"), ("every CRC", "crc 1"))
    ),
    _for_a_while("exoskeleton: one CRC in a hundred damaged", _OPERATOR, "damage can crc 0.01", _CONTINUES),
    _found("exoskeleton's encoder jumps", _OPERATOR, f"encoder {STROKING} glitch", 2.0),
    _found("exoskeleton's encoder or joint stuck", _OPERATOR, f"encoder {STROKING} stuck", 2.0),
    _found("telemanipulator's encoder jumps", _REMOTE, f"encoder {STROKING} glitch", 2.0),
    _found("telemanipulator's joint stuck", _REMOTE, f"disobey {FREE}", 8.0),
    _found("telemanipulator's encoder stuck", _REMOTE, f"encoder {FREE} stuck", 8.0),
    _found("telemanipulator's force sensor frozen", _REMOTE, f"force {STROKING} frozen", 1.0),
    _found("telemanipulator's force sensor biased", _REMOTE, f"force {STROKING} biased", 1.0),
    _for_a_while("texture sensor sends rubbish", _REMOTE, f"babble {STROKING} texture", _CONTINUES),
    _for_a_while("TactTip sends rubbish", _OPERATOR, f"babble {STROKING} tacttip", _CONTINUES),
    _for_a_while("texture sensor silent", _REMOTE, f"silence {STROKING} texture", _CONTINUES, _MOTOR),
    *(
        _for_a_while(f"texture sensor's element {fault}", _REMOTE, f"piezo {STROKING} {fault}", _CONTINUES, _MOTOR)
        for fault in ("cut", "saturated")
    ),
    _for_a_while(
        "TactTip silent and deaf", _OPERATOR, f"silence {STROKING} tacttip", _CONTINUES, _MOTOR | _PELTIER, STROKING
    ),
    # Before all other faults of this plate: after them it has no drive, and a frozen reading cannot be detected.
    _found("TactTip's thermistor frozen", _OPERATOR, f"thermistor {STROKING} frozen", 40.0),
    # Only the module's own temperature limit ends a stuck drive itself.
    _found("sensor's heater stuck on", _REMOTE, f"stuck {FREE} 1000", 2.0, ALL - _HEATER),
    _found("TactTip's Peltier stuck on", _OPERATOR, f"stuck {STROKING} 1000", 2.0, ALL - _PELTIER),
    _found("TactTip's motor stuck on", _OPERATOR, f"motor {STROKING} 2999", 1.0, ALL - _MOTOR),
    _found("exoskeleton pushes unasked", _OPERATOR, f"push {FREE} 2", 1.0, ALL - {Actuator.FORCE}),
    # An actuator that a second sender commands becomes neutral when the sender stops.
    _found("second sender on the exoskeleton's bus", _OPERATOR, "intrude", 0.5, ALL - {Actuator.FORCE}),
    _found("second sender on the telemanipulator's bus", _REMOTE, "intrude", 0.5, ALL - {Actuator.HAND}),
    _found("telemanipulator does not obey", _REMOTE, "disobey", 8.0),
    _found("telemanipulator drifts", _REMOTE, "disobey drift", 3.0, ALL - {Actuator.HAND}),
    *(
        _for_a_while(f"sensor's thermistor {fault}", _REMOTE, f"thermistor {FREE} {fault}", _CONTINUES, _HEATER, FREE)
        for fault in ("open", "short")
    ),
    Fault(
        "sensor's thermistor frozen, 6 s",
        _REMOTE,
        f"thermistor {FREE} frozen",
        _CONTINUES,
        _NONE,
        seconds=6.0,
        mend=f"mend thermistor {FREE}",
    ),
    _found("TactTip's thermistor open", _OPERATOR, f"thermistor {STROKING} open", 0.5),
    _found("TactTip's thermistor short", _OPERATOR, f"thermistor {STROKING} short", 0.5),
    # A stroke cools too little to warm a dry hot side within seconds. That case is tested on a virtual clock.
    _for_a_while("TactTip's cooling water lost", _OPERATOR, f"water {STROKING}", _CONTINUES),
)


def _process_faults(name: str, neutral: frozenset[Actuator], noticed_s: float = 0.0) -> tuple[Fault, ...]:
    def ended(how: str, begin: str, seconds: float, mend: str) -> Fault:
        return Fault(f"{name} {how}", name, begin, _RESUMES, neutral, None, seconds, mend, noticed_s)

    return (
        ended("killed (-9), started again", "kill", 2.0, "start"),
        # Shorter and longer than the silence that ends a session.
        *(ended(f"stopped for {seconds:g} s", "stop", seconds, "continue") for seconds in (1.0, 3.0)),
        Fault(f"{name} slowed: 10 ms of every 40, 3 s", name, "slow", _CONTINUES, _NONE, seconds=3.0),
    )


PROCESS_FAULTS = (
    *_process_faults("remote", ALL),
    *_process_faults("operator", ALL),
    # Actuators of a simulator that stands still cannot be judged meanwhile.
    *_process_faults("sim-remote", AT_FINGERS - {Actuator.PELTIER}, _SILENT),
    *_process_faults("sim-operator", AT_PATIENT, _SILENT),
    Fault("processor fully loaded, 4 s", "machine", "burn", _RESUMES, _NONE, seconds=4.0),
)
PLATE_FAULTS = (_found("TactTip's Peltiers reversed", _OPERATOR, f"reverse {STROKING}", 10.0),)
"""Faults for a session of their own: after another fault of this plate it has no drive until it has passed a test."""


def _leaves(name: str, begin: str, later_s: float, noticed_s: float = 0.0, network: str = "") -> Fault:
    """A press of the patient's stop switch, or a failure of the switch, which counts as one."""
    fault = _found(name, _REMOTE, begin, later_s)
    return replace(fault, noticed_s=noticed_s, network=network, leaves=True)


PATIENT_FAULTS = (
    _leaves("patient stop", "press", 0.1),
    _leaves("patient stop while the network is cut", "press", 0.1, network="partition 60"),
    _leaves("patient's switch unplugged", "unplug patient switch", 0.1),
    _leaves("patient's switch silent", "silence patient switch", SWITCH_LOST_S + 0.1, SWITCH_SILENCE_S),
    _leaves("patient's switch repeats one report", "repeat", 0.1),
    _leaves("patient's switch sends rubbish", "babble patient switch", 0.1),
    _leaves("patient's slider beyond its end", "slider 1001", 0.1),
    # These come last: what the slider reports lowers the force limit for the rest of the session.
    _for_a_while("patient's slider stuck at no pain", _REMOTE, "slider 0", _CONTINUES),
    _for_a_while("patient's slider no longer reported", _REMOTE, "slider gone", _CONTINUES),
    _for_a_while("patient's slider stuck at the worst pain", _REMOTE, "slider 1000", _CONTINUES),
)
"""Faults for a session whose patient has a stop switch."""
DISK_FAULTS = (Fault("disk full at both sites", "disk", "full", _CONTINUES, _NONE, seconds=3.0),)
