"""What each actuator of both sites does when something fails: its safe output, who brings it there, and within what.

Times count from the last thing that was still right: the last accepted packet, the last command that the device heard,
or the tick in which the gate found the fault.
"""

from dataclasses import dataclass

from common.limits import FORCE_SAFE_S, GAP_S, MODULE_TIMEOUT_S, MOTOR_SAFE_S, THERMAL_SAFE_S
from common.timing.timeouts import FORCE_FALL_S, REPORT_S, RETREAT_AFTER_S, SLOWEST_RATE_HZ, in_ms

TICK_S = 1.0 / SLOWEST_RATE_HZ
"""One tick of the slowest loop that may be configured."""


@dataclass(frozen=True, slots=True)
class Way:
    """How an actuator becomes safe: within a time (s), by whom."""

    within_s: float
    by: str

    def __str__(self) -> str:
        return f"{in_ms(self.within_s)}, {self.by}"


@dataclass(frozen=True, slots=True)
class SafeState:
    """One actuator.

    Attributes:
        site, actuator: which.
        output: what is safe.
        link_silent: no packet is accepted any more; the site lives.
        site_dead: the site's process has ended or hangs.
        device_alone: the line between site and device is cut.
        fault: a gate has latched a fault, or a person has stopped the session.
    """

    site: str
    actuator: str
    output: str
    link_silent: Way
    site_dead: Way
    device_alone: Way
    fault: Way


def _left_alone(site: str, actuator: str, output: str, *, link_silent: Way, left: Way, fault: Way) -> SafeState:
    # To a device, a dead site and a cut line are the same: no good command comes.
    return SafeState(site, actuator, output, link_silent, site_dead=left, device_alone=left, fault=fault)


SAFE_STATES = (
    _left_alone(
        "operator",
        "finger force",
        "0 N",
        link_silent=Way(FORCE_SAFE_S, "gate, along a ramp"),
        left=Way(MODULE_TIMEOUT_S + FORCE_FALL_S, "exoskeleton, along a ramp"),
        fault=Way(FORCE_FALL_S, "gate, along a ramp"),
    ),
    _left_alone(
        "operator",
        "vibration motor",
        "0 V",
        link_silent=Way(MOTOR_SAFE_S, "gate"),
        left=Way(MODULE_TIMEOUT_S, "module"),
        fault=Way(TICK_S, "gate"),
    ),
    _left_alone(
        "operator",
        "Peltier element",
        "drive 0",
        link_silent=Way(THERMAL_SAFE_S, "gate"),
        left=Way(MODULE_TIMEOUT_S, "module"),
        fault=Way(2 * TICK_S, "gate"),
    ),
    _left_alone(
        "remote",
        "hand along the bench",
        "stands still",
        link_silent=Way(GAP_S + TICK_S, "gate"),
        left=Way(MODULE_TIMEOUT_S, "telemanipulator"),
        fault=Way(TICK_S, "gate"),
    ),
    _left_alone(
        "remote",
        "finger heights",
        f"stand still, never lower; while the site lives they rise clear {in_ms(RETREAT_AFTER_S)} later",
        link_silent=Way(GAP_S + TICK_S, "gate"),
        left=Way(MODULE_TIMEOUT_S, "telemanipulator"),
        fault=Way(TICK_S, "gate"),
    ),
    _left_alone(
        "remote",
        "sensor heater",
        "drive 0",
        link_silent=Way(THERMAL_SAFE_S, "gate"),
        left=Way(MODULE_TIMEOUT_S, "sensor"),
        fault=Way(REPORT_S + TICK_S, "gate"),
    ),
)
