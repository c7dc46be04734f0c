"""The watchdog ladder: all times after which silence or standstill has a consequence, and their minimum lengths.

A timeout must be long enough for the shorter ones that it covers. Otherwise one late packet would be a gap, or a
process would end while its devices still wait for it. `check_ladder` checks a configuration against these rules.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from common.limits import (
    FINGER_FORCE_N,
    FORCE_RAMP_DOWN_N_S,
    FORCE_SAFE_S,
    GAP_S,
    MODULE_TIMEOUT_S,
    MOTOR_SAFE_S,
    MOTOR_STILL_S,
    PLATE_FAULT_C,
    PLATE_HEATING_K_S,
    SWITCH_LOST_S,
    SWITCH_SILENCE_S,
    THERMAL_SAFE_S,
    WIDE,
)
from common.wire.streams import STREAMS

SLOWEST_RATE_HZ, FASTEST_RATE_HZ = 100.0, 1000.0
"""Minimum and maximum rate of a site's loop, Hz."""
REFRESH_S = 0.012
"""Maximum interval between two packets of a stream, s, while its values do not change."""
SECOND_REFRESH_S = 0.024
"""The same for touch that is sent on two connections, s: so the second one costs no more packets."""
FRAME_S = 0.002
"""Minimum interval between two encoder readings of a CAN node, s: encoders are read at 500 Hz."""
REPORT_S = 0.010
"""Interval between two reports of a serial module with a thermometer, s."""
COMMAND_REFRESH_S = 0.020
"""Age at which an unchanged command of a serial module is repeated, s."""
TICK_AGE_S = 0.070
"""Maximum age of a tick's decision, s; an older one is not sent, and the gate restarts from neutral. A stopped process
finishes its tick on waking, while its devices may have gone to their safe states."""
STANDSTILL_S = 0.050
"""Minimum gain of a device's clock on the host's that shows a standstill, s; less is delay and drift."""
FORCE_FALL_S = FINGER_FORCE_N / FORCE_RAMP_DOWN_N_S
"""Time from full force to none, s, in the gate and in the exoskeleton itself."""
RETREAT_AFTER_S = 0.100
"""Time for which a stopped remote finger stands before it retreats, s."""
SESSION_SILENCE_S = 1.5
"""Maximum silence in a session, s: on the slowest link a hello, its answer and the first heartbeat take this time."""
MOTION_SILENCE_S = 5.0
"""Maximum time without motion in an engaged session, s; later, nothing at the patient may begin to move by itself."""
SITE_WATCHDOG_S = 1.5
NOTICE_S = 1.0
"""Interval between two status files, and between two notifications of the supervisor, s."""
SUPERVISOR_WATCHDOG_S = 5.0

_ROUNDING_S = 1e-9


class InconsistentTimeouts(ValueError):
    """A timeout that is shorter than a time that it must cover; the message names both, with numbers."""


@dataclass(frozen=True, slots=True)
class Timeout:
    """One timeout of the ladder.

    Attributes:
        name: name of the timeout.
        after_s: the time, s.
        source: field or table that contains it.
        then: consequence when the time is over.
        covers: sums of other timeouts, `{name: how many times}`; it must be at least as long as each.
    """

    name: str
    after_s: float
    source: str
    then: str
    covers: tuple[Mapping[str, float], ...] = ()


def ladder(rate_hz: float, gap_s: float, age_s: float, far_rate_hz: float | None = None) -> tuple[Timeout, ...]:
    """Return the timeouts of one site, each after those that it covers.

    Args:
        rate_hz: rate of this site's loop, Hz.
        gap_s: maximum gap between accepted packets, s; after it outputs go to safe.
        age_s: maximum age of a packet, s.
        far_rate_hz: rate of the far side's loop, Hz, which sends at most one packet a tick; None while unknown.
    """
    period_s = 1.0 / rate_hz
    far = (
        () if far_rate_hz is None else (Timeout("far loop", 1.0 / far_rate_hz, "far side's rate_hz", "a packet comes"),)
    )
    return (
        Timeout("loop", period_s, "rate_hz", "read, compute, pass the gate, write, send a packet"),
        *far,
        Timeout("refresh", REFRESH_S, "deadband", "a far side with no news sends a packet"),
        Timeout("heartbeat", 1.0 / STREAMS["heartbeat"].rate_hz, "streams", "clocks are compared"),
        Timeout("report", REPORT_S, "protocol", "a serial module says what it measures"),
        Timeout("command", COMMAND_REFRESH_S + period_s, "protocol", "an unchanged command is repeated"),
        Timeout("force fall", FORCE_FALL_S, "limits", "full force has gone to 0", ({"loop": 5},)),
        Timeout(
            "standstill", STANDSTILL_S, "devices", "the site's clock is put forward by a standstill", ({"report": 3},)
        ),
        Timeout(
            "tick age",
            TICK_AGE_S,
            "site loop",
            "an older decision of a tick is not sent; outputs start from neutral",
            ({"loop": 3}, {"standstill": 1, "report": 1}),
        ),
        Timeout(
            "gap",
            gap_s,
            "link.gap_s",
            "no accepted packet: the gate brings the outputs to safe",
            ({"loop": 3}, {"far loop": 3}, {"refresh": 3}),
        ),
        Timeout(
            "reading age",
            GAP_S,
            "limits",
            "no reading: that plate's drive is off, that finger retreats",
            ({"loop": 3}, {"report": 3}),
        ),
        Timeout(
            "device time-out",
            MODULE_TIMEOUT_S,
            "limits",
            "no good command: the device turns its own outputs off",
            ({"loop": 3}, {"command": 3}, {"command": 1, "tick age": 1}),
        ),
        Timeout("age", age_s, "link.max_age_s", "an older packet is refused; the gap continues", ({"loop": 3},)),
        Timeout(
            "force hold",
            FORCE_SAFE_S,
            "limits",
            "finger force is 0",
            ({"gap": 1, "force fall": 1}, {"device time-out": 1, "force fall": 1}),
        ),
        Timeout(
            "motor hold",
            MOTOR_SAFE_S,
            "limits",
            "motor drive is 0",
            ({"gap": 1, "loop": 2}, {"device time-out": 1, "loop": 1}),
        ),
        Timeout(
            "thermal hold",
            THERMAL_SAFE_S,
            "limits",
            "Peltier and heater drives are 0",
            ({"gap": 1, "command": 1}, {"device time-out": 1, "report": 1}),
        ),
        Timeout(
            "motor still", MOTOR_STILL_S, "limits", "the motor is below the perception floor", ({"motor hold": 1},)
        ),
        Timeout(
            "retreat", GAP_S + RETREAT_AFTER_S, "patient gate", "stopped remote fingers rise", ({"gap": 1, "loop": 3},)
        ),
        Timeout(
            "switch silence",
            SWITCH_SILENCE_S,
            "limits",
            "no report of the patient's stop switch: remote fingers rise at once",
            ({"loop": 3}, {"report": 3}),
        ),
        Timeout(
            "switch lost",
            SWITCH_LOST_S,
            "limits",
            "no report of the patient's stop switch: a latched fault",
            ({"switch silence": 1, "gap": 1},),
        ),
        Timeout(
            "session silence",
            SESSION_SILENCE_S,
            "session",
            "no heartbeat: the session ends, the operator sends hello again",
            # A hello, its answer and the first heartbeat each travel one way, one after the other.
            ({"heartbeat": 5}, {"age": 3}, {"force hold": 1}, {"thermal hold": 1}, {"motor still": 1}, {"retreat": 1}),
        ),
        Timeout(
            "motion silence",
            MOTION_SILENCE_S,
            "session",
            "no motion, although heartbeats come: the remote site disengages",
            ({"session silence": 2}, {"retreat": 1}),
        ),
        Timeout(
            "site watchdog",
            SITE_WATCHDOG_S,
            "watchdog",
            "the loop made no tick: its process ends with exit code 70",
            ({"loop": 50}, {"session silence": 1}, {"thermal hold": 1}, {"motor still": 1}),
        ),
        Timeout("sign of life", NOTICE_S, "site loop", "status file rewritten, supervisor notified", ({"loop": 3},)),
        Timeout(
            "supervisor's watchdog",
            SUPERVISOR_WATCHDOG_S,
            "deploy/systemd",
            "no sign of life: unhealthy; the supervisor kills and restarts the process",
            ({"sign of life": 3}, {"site watchdog": 1, "sign of life": 1}),
        ),
        Timeout(
            "thermal cut-out",
            (PLATE_FAULT_C - WIDE.high_c) / PLATE_HEATING_K_S,
            "limits",
            f"a plate that keeps heating from the end of its range is at {PLATE_FAULT_C:g} °C: the module cuts its "
            "supply, independently of all else",
            ({"device time-out": 1},),
        ),
    )


def check_ladder(rate_hz: float, gap_s: float, age_s: float, far_rate_hz: object = None) -> None:
    """Check the timeouts of one site against the times that they must cover.

    Called when a configuration is loaded, and at hello with the far side's rate as received.

    Raises:
        InconsistentTimeouts: a timeout is too short, or the far side's rate is invalid.
    """
    far = None if far_rate_hz is None else _rate(far_rate_hz)
    timeouts = {timeout.name: timeout for timeout in ladder(rate_hz, gap_s, age_s, far)}
    for timeout in timeouts.values():
        for parts in timeout.covers:
            if not parts.keys() <= timeouts.keys():
                continue  # a timeout of the far side, which is unknown
            least_s = sum(times * timeouts[name].after_s for name, times in parts.items())
            if not timeout.after_s >= least_s - _ROUNDING_S:
                raise InconsistentTimeouts(
                    f"{timeout.source}: {timeout.name} of {in_ms(timeout.after_s)} must cover "
                    f"{_sum(parts, timeouts)} = {in_ms(least_s)}"
                )


def in_ms(time_s: float) -> str:
    """Return a time for people: `100 ms`, `5 s`."""
    return f"{time_s:g} s" if time_s >= 1.0 else f"{time_s * 1e3:.4g} ms"


def _rate(given: object) -> float:
    number = given if isinstance(given, (int, float)) and not isinstance(given, bool) else math.nan
    if not SLOWEST_RATE_HZ <= number <= FASTEST_RATE_HZ:
        raise InconsistentTimeouts(
            f"far side's rate_hz: {str(given)[:40]} is not in {SLOWEST_RATE_HZ:g}..{FASTEST_RATE_HZ:g} Hz: "
            "correct the far side's configuration"
        )
    return number


def _sum(parts: Mapping[str, float], timeouts: Mapping[str, Timeout]) -> str:
    def part(name: str, times: float) -> str:
        timeout = timeouts[name]
        return f"{f'{times:g} x ' if times != 1 else ''}{name} ({timeout.source}) of {in_ms(timeout.after_s)}"

    return " + ".join(part(name, times) for name, times in parts.items())
