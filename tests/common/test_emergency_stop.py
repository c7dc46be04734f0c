import pytest

from common.emergency_stop import PATIENCE_NS, Confirmation, EmergencyStop
from common.limits import FORCE_SAFE_S, MOTOR_SAFE_S, THERMAL_SAFE_S

MS = 1_000_000
T0 = 5_000_000 * MS


def test_nothing_is_confirmed_that_was_not_asked_for() -> None:
    assert EmergencyStop().step(T0, lambda _: "") is None


def test_it_is_over_when_every_device_has_confirmed_since_it_was_asked_for() -> None:
    stop, off_ns = EmergencyStop(), T0 + 12 * MS
    stop.ask(T0)

    def step(now_ns: int) -> Confirmation | None:
        off = now_ns >= off_ns
        return stop.step(now_ns, lambda since_s: "" if off and since_s <= off_ns * 1e-9 else "index tacttip")

    outcomes = [step(now_ns) for now_ns in range(T0, T0 + 50 * MS, 2 * MS)]
    (confirmed,) = [outcome for outcome in outcomes if outcome is not None]
    assert confirmed.after_s == pytest.approx(0.012, abs=0.002)
    assert confirmed.unconfirmed == ""
    assert "confirmed by every device after" in str(confirmed)


def test_who_does_not_confirm_in_time_is_named() -> None:
    stop = EmergencyStop()
    stop.ask(T0)
    assert stop.step(T0 + PATIENCE_NS - MS, lambda _: "exoskeleton") is None
    stop.ask(T0 + PATIENCE_NS - MS)  # asking again changes nothing
    outcome = stop.step(T0 + PATIENCE_NS, lambda _: "exoskeleton")
    assert outcome is not None
    assert str(outcome) == "stopped, but not confirmed within 300 ms by exoskeleton"
    assert stop.step(T0 + 2 * PATIENCE_NS, lambda _: "exoskeleton") is None


def test_the_patience_covers_the_slowest_output() -> None:
    assert max(THERMAL_SAFE_S, FORCE_SAFE_S, MOTOR_SAFE_S) < PATIENCE_NS * 1e-9
