import pytest

from common.limits import FORCE_SAFE_S, MOTOR_SAFE_S, THERMAL_SAFE_S
from common.link.emergency_stop import PATIENCE_NS, Confirmation, EmergencyStop

MS = 1_000_000
T0 = 5_000_000 * MS


def test_a_stop_is_over_once_every_device_has_confirmed_after_its_request() -> None:
    stop, off_ns = EmergencyStop(), T0 + 12 * MS
    assert stop.step(T0, lambda _: {}) is None, "nothing was asked for"
    stop.ask(T0)

    def step(now_ns: int) -> Confirmation | None:
        off = now_ns >= off_ns
        return stop.step(
            now_ns, lambda since_s: {"index tacttip": "" if off and since_s <= off_ns * 1e-9 else "no report"}
        )

    outcomes = [step(now_ns) for now_ns in range(T0, T0 + 50 * MS, 2 * MS)]
    (confirmed,) = [outcome for outcome in outcomes if outcome is not None]
    assert confirmed.after_s == pytest.approx(0.012, abs=0.002)
    assert confirmed.unconfirmed == ""
    assert "confirmed by every device after" in str(confirmed)


def test_a_device_that_does_not_confirm_in_time_is_named() -> None:
    stop = EmergencyStop()
    stop.ask(T0)
    assert stop.step(T0 + PATIENCE_NS - MS, lambda _: {"exoskeleton": "no report"}) is None
    stop.ask(T0 + PATIENCE_NS - MS)  # asking again changes nothing
    outcome = stop.step(T0 + PATIENCE_NS, lambda _: {"exoskeleton": "no report"})
    assert outcome is not None
    assert str(outcome) == "stopped, but not confirmed within 300 ms by exoskeleton: no report"
    assert stop.step(T0 + 2 * PATIENCE_NS, lambda _: {"exoskeleton": "no report"}) is None


def test_each_device_is_reported_with_its_own_time_even_a_late_one() -> None:
    stop, off_ns = EmergencyStop(), {"exoskeleton": T0 + 10 * MS, "index tacttip": T0 + PATIENCE_NS + 50 * MS}
    stop.ask(T0)
    for now_ns in range(T0, T0 + PATIENCE_NS + 100 * MS, 2 * MS):
        stop.step(now_ns, lambda _, at=now_ns: {name: "" if at >= ns else "on" for name, ns in off_ns.items()})
        assert stop.after_s.get("index tacttip") is None or now_ns >= off_ns["index tacttip"]
    assert stop.asked_ns == T0
    assert stop.after_s == {"exoskeleton": pytest.approx(0.010), "index tacttip": pytest.approx(0.350)}


def test_a_device_that_is_on_again_has_not_confirmed() -> None:
    stop = EmergencyStop()
    stop.ask(T0)
    stop.step(T0 + 2 * MS, lambda _: {"exoskeleton": "", "index tacttip": "on"})
    assert stop.after_s["exoskeleton"] == pytest.approx(0.002)
    stop.step(T0 + 4 * MS, lambda _: {"exoskeleton": "enabled", "index tacttip": "on"})
    assert stop.after_s == {"exoskeleton": None, "index tacttip": None}


def test_a_stop_is_forgotten_with_its_fault_but_not_before_its_confirmation() -> None:
    stop = EmergencyStop()
    stop.ask(T0)
    stop.forget()
    assert stop.asked_ns == T0
    assert stop.step(T0 + 2 * MS, lambda _: {"exoskeleton": ""}) is not None
    stop.forget()
    assert (stop.asked_ns, stop.after_s) == (None, {})


def test_the_timeout_covers_the_slowest_output() -> None:
    assert max(THERMAL_SAFE_S, FORCE_SAFE_S, MOTOR_SAFE_S) < PATIENCE_NS * 1e-9
