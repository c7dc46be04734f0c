"""Safe state of each actuator of both sites: its safe output, and for each failure the maximum time and who acts.

Times count from the last accepted packet, from the last command that the device received, or from the tick in which
the gate detected the fault.
"""

from dataclasses import dataclass

from common.limits import FORCE_SAFE_S, GAP_S, MODULE_TIMEOUT_S, MOTOR_SAFE_S, THERMAL_SAFE_S
from common.timing.timeouts import FORCE_FALL_S, REPORT_S, RETREAT_AFTER_S, SLOWEST_RATE_HZ, in_ms

TICK_S = 1.0 / SLOWEST_RATE_HZ
"""Period of the slowest loop that may be configured, s."""


@dataclass(frozen=True, slots=True)
class Way:
    """How an actuator becomes safe: the maximum time, s, and who acts."""

    within_s: float
    by: str

    def __str__(self) -> str:
        return f"{in_ms(self.within_s)}, {self.by}"


@dataclass(frozen=True, slots=True)
class SafeState:
    """One actuator.

    Attributes:
        site, actuator: names of the site and the actuator.
        output: safe output.
        link_silent: no packet is accepted, and the site runs.
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
    # For a device, a dead site and a cut line are the same: no valid command arrives.
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
