"""`python -m common.limits_table`: docs/limits.md, from the numbers that the gates use."""

from common import limits


def limits_page() -> str:
    """The table of limits as Markdown."""
    comfort, wide = limits.COMFORT, limits.WIDE
    rows = {
        "operator plate, set-point": f"{comfort.low_c:g}-{comfort.high_c:g} °C (comfort, the default), "
        f"{wide.low_c:g}-{wide.high_c:g} °C (wide)",
        "operator plate, measured": f"a fault above {limits.PLATE_FAULT_C:g} °C; "
        f"after any single fault never above {limits.PLATE_PEAK_C:g} °C",
        "operator plate, rate of the set-point": f"+{limits.PLATE_HEATING_K_S:g} / -{limits.PLATE_COOLING_K_S:g} K/s",
        "skin dose, both sites": f"the integral of max(0, T - {limits.DOSE_ABOVE_C:g} °C) over any "
        f"{limits.DOSE_WINDOW_S:g} s stays within {limits.DOSE_LIMIT_K_S:g} K s",
        "finger force": f"{limits.FINGER_FORCE_N:g} N; ramps +{limits.FORCE_RAMP_UP_N_S:g} / "
        f"-{limits.FORCE_RAMP_DOWN_N_S:g} N/s on engaging, disengaging and model updates",
        "vibration motor": f"0, or {limits.MOTOR_FLOOR_RPM:g}-{limits.MOTOR_MAX_RPM:g} rpm",
        "patient side, sensor plate": f"{limits.SENSOR_PLATE_C:g} °C",
        "patient side, contact force": f"{limits.CONTACT_FORCE_N:g} N by default",
        "gap without an accepted packet": f"{limits.GAP_S * 1e3:g} ms, then safe state",
        "age of a packet": f"{limits.AGE_DEFAULT_S * 1e3:g} ms by default, at most {limits.AGE_MAX_S * 1e3:g} ms",
        "from the last valid input": f"force 0 within {limits.FORCE_SAFE_S * 1e3:g} ms, "
        f"motor drive 0 within {limits.MOTOR_SAFE_S * 1e3:g} ms (below its floor within "
        f"{limits.MOTOR_STILL_S * 1e3:g} ms), Peltier and heater drive 0 within {limits.THERMAL_SAFE_S * 1e3:g} ms",
        "silence at a module": f"it switches its own outputs off after {limits.MODULE_TIMEOUT_S * 1e3:g} ms",
    }
    lines = [
        "# Limits",
        "",
        "Everything that may reach a finger or a patient stays inside this table. The numbers are those of",
        "`common/limits.py`; after a change there: `python -m common.limits_table > docs/limits.md`.",
        "",
        "| what | limit |",
        "|---|---|",
        *(f"| {what} | {limit} |" for what, limit in rows.items()),
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(limits_page(), end="")
