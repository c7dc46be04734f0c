"""Prints docs/limits.md from the numbers of gates, watchdogs and devices: `python -m common.limits_table`."""

from collections.abc import Iterable, Mapping

from common import limits
from common.buses.drive_monitor import MEMORY_S, NEAR_N, PERSIST_S
from common.config.site_models import OperatorConfig, RemoteConfig
from common.timing.safe_states import SAFE_STATES, TICK_S
from common.timing.timeouts import Timeout, in_ms, ladder

OPERATOR_HZ, REMOTE_HZ = (kind.model_fields["rate_hz"].default for kind in (OperatorConfig, RemoteConfig))
"""Default loop rates of the operator and the remote site, Hz, for the example on the page."""


def limits_page() -> str:
    """Return limits, watchdog ladder and safe states as Markdown."""
    parts = [
        "# Limits",
        "",
        "Every output to a finger or a patient stays within these tables. `common/limits.py`,",
        "`common/timing/timeouts.py` and `common/timing/safe_states.py` contain the numbers.",
        "After a change there, write this page again:",
        "`python -m common.limits_table > docs/limits.md`.",
        "",
        *_table(("what", "limit"), _limits().items()),
        "",
        "## The watchdog ladder",
        "",
        "This table lists every time after which silence or standstill has a consequence. The example is an operator",
        f"site with a loop of {OPERATOR_HZ:g} Hz. The far loop has {REMOTE_HZ:g} Hz.",
        "",
        "A timeout must be at least as long as each sum in its last column. A configuration that breaks this rule is",
        "refused when it is loaded. A far side whose rate breaks it is refused at hello.",
        "",
        *_table(("timeout", "time", "set by", "consequence", "at least"), _timeouts()),
        "",
        "## Safe states",
        "",
        "Each actuator reaches its safe output within these times. The cause is a silent link, a site that is dead or",
        "hangs, a cut line between site and device, or a latched fault. Times count from the last accepted packet,",
        "from the last command that the device received, or from the tick that detected the fault. A tick is at most",
        f"{in_ms(TICK_S)}.",
        "",
        *_table(
            ("site", "actuator", "safe output", "link silent", "site dead", "device alone", "fault"),
            (
                (s.site, s.actuator, s.output, str(s.link_silent), str(s.site_dead), str(s.device_alone), str(s.fault))
                for s in SAFE_STATES
            ),
        ),
    ]
    return "\n".join(parts) + "\n"


def _limits() -> Mapping[str, str]:
    comfort, wide = limits.COMFORT, limits.WIDE
    return {
        "operator plate, set-point": f"{comfort.low_c:g}-{comfort.high_c:g} °C (comfort, the default), "
        f"{wide.low_c:g}-{wide.high_c:g} °C (wide)",
        "operator plate, measured": f"a fault above {limits.PLATE_FAULT_C:g} °C; "
        f"after any single fault never above {limits.PLATE_PEAK_C:g} °C",
        "operator plate, rate of the set-point": f"+{limits.PLATE_HEATING_K_S:g} / -{limits.PLATE_COOLING_K_S:g} K/s",
        "skin dose, both sites": f"the integral of max(0, T - {limits.DOSE_ABOVE_C:g} °C) over any "
        f"{limits.DOSE_WINDOW_S:g} s stays within {limits.DOSE_LIMIT_K_S:g} K s",
        "finger force": f"{limits.FINGER_FORCE_N:g} N; ramps +{limits.FORCE_RAMP_UP_N_S:g} / "
        f"-{limits.FORCE_RAMP_DOWN_N_S:g} N/s on engaging, disengaging and model updates",
        "energy at a finger": f"{limits.PRODUCED_J * 1e3:g} mJ more than the finger put in; then force is released",
        "oscillation of a force, both sites": f"of {limits.SWING_N:g} N: a fault after {limits.SWING_CYCLES} cycles "
        f"within {limits.SWING_S:g} s, or after {limits.SWING_SLOW_CYCLES} at {limits.SWING_SLOW_HZ:g} Hz or more "
        "in which an energy limit acts",
        "vibration motor": f"0, or {limits.MOTOR_FLOOR_RPM:g}-{limits.MOTOR_MAX_RPM:g} rpm",
        "patient side, sensor plate": f"{limits.SENSOR_PLATE_C:g} °C",
        "patient side, contact force": f"{limits.CONTACT_FORCE_N:g} N by default",
        "patient side, work left in the object": f"{limits.LEFT_J * 1e3:g} mJ at once and "
        f"{limits.LEFT_W * 1e3:g} mW continuously at each finger",
        "patient side, approach to the operator's hand": f"{limits.APPROACH_PLANE_M_S * 1e3:g} mm/s along the bench; "
        f"then fingers are lowered at {limits.APPROACH_DOWN_M_S * 1e3:g} mm/s, until both hands agree",
        "patient's own stop": f"contact force falls within {limits.PATIENT_STOP_S * 1e3:g} ms, then the fingers leave "
        f"at {limits.RETREAT_M_S * 1e3:g} mm/s, from a depth of 10 mm within {limits.LIFT_OFF_S * 1e3:g} ms; "
        "it needs no network",
        "patient's stop switch": f"silent for {limits.SWITCH_SILENCE_S * 1e3:g} ms, it stops as a press does; "
        f"for {limits.SWITCH_LOST_S * 1e3:g} ms, it is a latched fault; "
        f"it reports a press for {limits.SWITCH_HOLD_S * 1e3:g} ms at least",
        "patient's own threshold": f"after a report of pain, contact force at most {100 * limits.PAIN_SHARE:g} % of "
        f"the force at which the pain began, or {limits.PAIN_LEAST_N:g} N if that is more; only a person ends it",
        "motion scale": f"{', '.join(f'1:{n}' for n in limits.MOTION_SCALES)}; the remote hand's limits stay in its "
        f"own units; at a change of clutch or scale no step above {limits.COUPLING_STEP_M * 1e3:g} mm or "
        f"{limits.COUPLING_STEP_N:g} N",
        "gap without an accepted packet": f"{limits.GAP_S * 1e3:g} ms, then safe state",
        "age of a packet": f"{limits.AGE_DEFAULT_S * 1e3:g} ms by default, at most {limits.AGE_MAX_S * 1e3:g} ms",
        "age of the camera's picture": f"{limits.FROZEN_S * 1e3:g} ms, then it is named late or frozen; the session "
        "pauses where the console's configuration requires the picture",
        "age of a sound of the voice": f"{limits.VOICE_AGE_S * 1e3:g} ms, then it is dropped; touch is not affected",
        "from the last valid input": f"force 0 within {limits.FORCE_SAFE_S * 1e3:g} ms, "
        f"motor drive 0 within {limits.MOTOR_SAFE_S * 1e3:g} ms (below its floor within "
        f"{limits.MOTOR_STILL_S * 1e3:g} ms), Peltier and heater drive 0 within {limits.THERMAL_SAFE_S * 1e3:g} ms",
        "commanded against applied": "every output of both sites is compared with the report of its device: an output "
        f"not commanded in the last {MEMORY_S * 1e3:g} ms, or a force more than {NEAR_N:g} N from the command, is a "
        f"latched fault after {PERSIST_S * 1e3:g} ms",
        "silence at a module": f"it turns its own outputs off after {limits.MODULE_TIMEOUT_S * 1e3:g} ms",
    }


def _timeouts() -> Iterable[tuple[str, ...]]:
    timeouts = ladder(OPERATOR_HZ, limits.GAP_S, limits.AGE_DEFAULT_S, REMOTE_HZ)
    return (
        (timeout.name, in_ms(timeout.after_s), timeout.source, timeout.then, _covers(timeout)) for timeout in timeouts
    )


def _covers(timeout: Timeout) -> str:
    sums = (
        " + ".join(name if times == 1 else f"{times:g} x {name}" for name, times in parts.items())
        for parts in timeout.covers
    )
    return "; ".join(sums) or "-"


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> list[str]:
    return [
        f"| {' | '.join(head)} |",
        "|" + "---|" * len(head),
        *(f"| {' | '.join(cells)} |" for cells in rows),
    ]


if __name__ == "__main__":
    print(limits_page(), end="")
