"""Signs and order of the one table of limits; the values themselves are a decision, not a theorem."""

from common import limits as t


def test_profiles_lie_within_each_other_and_below_the_fault() -> None:
    assert t.WIDE.low_c < t.COMFORT.low_c < t.COMFORT.high_c < t.WIDE.high_c < t.PLATE_FAULT_C < t.PLATE_PEAK_C
    assert set(t.PLATE_PROFILES.values()) == {t.COMFORT, t.WIDE}
    assert t.COMFORT.high_c < t.DOSE_ABOVE_C < t.WIDE.high_c
    assert t.SENSOR_PLATE_C <= 42.0


def test_rates_and_amounts_are_positive() -> None:
    for name in (
        "PLATE_HEATING_K_S",
        "PLATE_COOLING_K_S",
        "DOSE_LIMIT_K_S",
        "DOSE_WINDOW_S",
        "FINGER_FORCE_N",
        "FORCE_RAMP_UP_N_S",
        "FORCE_RAMP_DOWN_N_S",
        "MOTOR_FLOOR_RPM",
        "CONTACT_FORCE_N",
        "GAP_S",
    ):
        assert getattr(t, name) > 0.0, name
    assert t.FORCE_RAMP_DOWN_N_S >= 200.0 > t.FORCE_RAMP_UP_N_S
    assert t.MOTOR_FLOOR_RPM < t.MOTOR_MAX_RPM
    assert t.CONTACT_FORCE_N < t.FINGER_FORCE_N <= 10.0


def test_hold_times_leave_room_for_the_way_to_safe() -> None:
    assert t.GAP_S < t.AGE_DEFAULT_S <= t.AGE_MAX_S <= 0.5
    assert t.GAP_S + t.FINGER_FORCE_N / t.FORCE_RAMP_DOWN_N_S <= t.FORCE_SAFE_S + 1e-9
    assert t.GAP_S < t.MOTOR_SAFE_S < t.MOTOR_STILL_S
    assert max(t.GAP_S, t.MODULE_TIMEOUT_S) < t.THERMAL_SAFE_S
