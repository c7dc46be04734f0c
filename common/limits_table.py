"""`python -m common.limits_table`: docs/limits.md, from the numbers that gates, watchdogs and devices use."""

from collections.abc import Iterable, Mapping

from common import limits
from common.config import OperatorConfig, RemoteConfig
from common.drive_obeys import MEMORY_S, NEAR_N, PERSIST_S
from common.ladder import Rung, in_ms, ladder
from common.safe_states import SAFE_STATES, TICK_S

OPERATOR_HZ, REMOTE_HZ = (kind.model_fields["rate_hz"].default for kind in (OperatorConfig, RemoteConfig))
"""Usual rates of the loops, for the ladder that the page shows."""


def limits_page() -> str:
    """Limits, watchdog ladder and safe states as Markdown."""
    parts = [
        "# Limits",
        "",
        "Everything that may reach a finger or a patient stays inside these tables. The numbers are the code's own",
        "(`common/limits.py`, `common/ladder.py`, `common/safe_states.py`); after a change there:",
        "`python -m common.limits_table > docs/limits.md`.",
        "",
        *_table(("what", "limit"), _limits().items()),
        "",
        "## The watchdog ladder",
        "",
        "Each time after which silence or standstill has a consequence, lowest first, here at the operator's site: "
        f"its loop of {OPERATOR_HZ:g} Hz, the far loop of {REMOTE_HZ:g} Hz.",
        "A time acts only after those that it covers have had their turn. A configuration that breaks this is refused",
        "when it is loaded, and a far side whose rate breaks it at hello.",
        "",
        *_table(("waited for", "time", "set by", "then", "covers"), _rungs()),
        "",
        "## Safe states",
        "",
        "What each actuator does, and within what time, when the link is silent, its site is dead or hangs, its own",
        "line is cut, or a fault has latched. Times count from the last accepted packet, the last command that the",
        f"device heard, or the tick that found the fault; a tick is at most {in_ms(TICK_S)}.",
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
        "energy at a finger": f"{limits.PRODUCED_J * 1e3:g} mJ more than it put in may come out; force is let go",
        "a force that swings, both sites": f"by {limits.SWING_N:g} N: a fault after {limits.SWING_CYCLES} cycles "
        f"within {limits.SWING_S:g} s, or after {limits.SWING_SLOW_CYCLES} at {limits.SWING_SLOW_HZ:g} Hz or more "
        "in which an energy limit acts",
        "vibration motor": f"0, or {limits.MOTOR_FLOOR_RPM:g}-{limits.MOTOR_MAX_RPM:g} rpm",
        "patient side, sensor plate": f"{limits.SENSOR_PLATE_C:g} °C",
        "patient side, contact force": f"{limits.CONTACT_FORCE_N:g} N by default",
        "patient side, work left in what is touched": f"{limits.LEFT_J * 1e3:g} mJ at once and "
        f"{limits.LEFT_W * 1e3:g} mW lastingly at each finger",
        "patient side, coming to the operator's hand": f"{limits.APPROACH_PLANE_M_S * 1e3:g} mm/s along the bench; "
        f"then fingers are lowered at {limits.APPROACH_DOWN_M_S * 1e3:g} mm/s, until they have met",
        "gap without an accepted packet": f"{limits.GAP_S * 1e3:g} ms, then safe state",
        "age of a packet": f"{limits.AGE_DEFAULT_S * 1e3:g} ms by default, at most {limits.AGE_MAX_S * 1e3:g} ms",
        "from the last valid input": f"force 0 within {limits.FORCE_SAFE_S * 1e3:g} ms, "
        f"motor drive 0 within {limits.MOTOR_SAFE_S * 1e3:g} ms (below its floor within "
        f"{limits.MOTOR_STILL_S * 1e3:g} ms), Peltier and heater drive 0 within {limits.THERMAL_SAFE_S * 1e3:g} ms",
        "asked against applied": "every output of both sites is compared with what its device reports: what was not "
        f"asked for in the last {MEMORY_S * 1e3:g} ms, or a force more than {NEAR_N:g} N away from it, is a latched "
        f"fault after {PERSIST_S * 1e3:g} ms",
        "silence at a module": f"it switches its own outputs off after {limits.MODULE_TIMEOUT_S * 1e3:g} ms",
    }


def _rungs() -> Iterable[tuple[str, ...]]:
    rungs = ladder(OPERATOR_HZ, limits.GAP_S, limits.AGE_DEFAULT_S, REMOTE_HZ)
    return ((rung.name, in_ms(rung.after_s), rung.source, rung.then, _covers(rung)) for rung in rungs)


def _covers(rung: Rung) -> str:
    sums = (
        " + ".join(name if times == 1 else f"{times:g} x {name}" for name, times in parts.items())
        for parts in rung.covers
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
