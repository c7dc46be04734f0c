"""The hierarchy of timeouts: an accepted configuration keeps its order, another one is refused with both numbers."""

import math
import re
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common import limits
from common.timing import timeouts as table
from common.timing.timeouts import REFRESH_S, InconsistentTimeouts, check_ladder, in_ms, ladder
from common.wire.streams import STREAMS
from operator_site.session import session_client
from remote_site.safety import setpoints
from remote_site.session import session_server
from sim_sensors.devices import exoskeleton

RATES = st.floats(table.SLOWEST_RATE_HZ, table.FASTEST_RATE_HZ)


@given(RATES, st.floats(0.001, limits.AGE_MAX_S), st.none() | RATES)
def test_with_the_usual_gap_every_rate_and_age_of_at_least_three_periods_stands(
    rate_hz: float, age_s: float, far_rate_hz: float | None
) -> None:
    if age_s >= 3.0 / rate_hz:
        check_ladder(rate_hz, limits.GAP_S, age_s, far_rate_hz)
    else:
        with pytest.raises(InconsistentTimeouts, match=r"link\.max_age_s: age of .* must cover 3 x loop"):
            check_ladder(rate_hz, limits.GAP_S, age_s, far_rate_hz)


@given(RATES, st.floats(0.001, limits.GAP_S), RATES)
def test_a_gap_is_refused_exactly_when_it_is_shorter_than_three_periods_of_either_side_or_three_refreshes(
    rate_hz: float, gap_s: float, far_rate_hz: float
) -> None:
    least_s = 3.0 * max(1.0 / rate_hz, 1.0 / far_rate_hz, REFRESH_S)
    if abs(gap_s - least_s) < 1e-6:
        return
    if gap_s > least_s:
        check_ladder(rate_hz, gap_s, limits.AGE_DEFAULT_S, far_rate_hz)
    else:
        with pytest.raises(InconsistentTimeouts, match=r"link\.gap_s"):
            check_ladder(rate_hz, gap_s, limits.AGE_DEFAULT_S, far_rate_hz)


def test_the_error_names_both_rungs_with_their_fields_and_numbers() -> None:
    with pytest.raises(InconsistentTimeouts) as caught:
        check_ladder(500.0, 0.020, 0.150, 100.0)
    check_ladder(500.0, 0.040, 0.150)  # what the far side would need is not judged before it is known
    assert str(caught.value) == "link.gap_s: gap of 20 ms must cover 3 x far loop (far side's rate_hz) of 10 ms = 30 ms"


@pytest.mark.parametrize("rate_hz", ["500", True, math.nan, math.inf, -500.0, 0, 99.9, 1001, [500], {}, 10**400])
def test_a_peer_without_a_valid_loop_rate_is_refused(rate_hz: object) -> None:
    with pytest.raises(InconsistentTimeouts, match=r"far side's rate_hz: .* is not in 100\.\.1000 Hz"):
        check_ladder(500.0, limits.GAP_S, limits.AGE_DEFAULT_S, rate_hz)


@pytest.mark.parametrize(
    ("name", "wrong_s", "says"),
    [
        ("SESSION_SILENCE_S", 0.2, "session silence of 200 ms must cover 5 x heartbeat"),
        (
            "SESSION_SILENCE_S",
            0.28,
            r"session silence of 280 ms must cover 3 x age \(link\.max_age_s\) of 150 ms = 450 ms",
        ),
        ("SITE_WATCHDOG_S", 0.9, "site watchdog of 900 ms must cover session silence"),
        ("SUPERVISOR_WATCHDOG_S", 2.9, "supervisor's watchdog of 2.9 s must cover 3 x sign of life"),
        ("MODULE_TIMEOUT_S", 0.060, "device time-out of 60 ms must cover 3 x command"),
        ("MODULE_TIMEOUT_S", 0.120, "force hold of 150 ms must cover device time-out .* of 120 ms . force fall"),
        ("FORCE_FALL_S", 0.060, "force hold of 150 ms must cover gap .* of 100 ms . force fall .* of 60 ms = 160 ms"),
        ("THERMAL_SAFE_S", 0.110, "thermal hold of 110 ms must cover gap"),
        ("MOTOR_SAFE_S", 0.100, "motor hold of 100 ms must cover gap"),
        ("PLATE_HEATING_K_S", 6.0, "thermal cut-out of 83.33 ms must cover device time-out"),
    ],
)
def test_a_number_of_the_code_that_acts_too_early_is_found(
    monkeypatch: pytest.MonkeyPatch, name: str, wrong_s: float, says: str
) -> None:
    check_ladder(500.0, limits.GAP_S, limits.AGE_DEFAULT_S, 500.0)
    monkeypatch.setattr(table, name, wrong_s)
    with pytest.raises(InconsistentTimeouts, match=says):
        check_ladder(500.0, limits.GAP_S, limits.AGE_DEFAULT_S, 500.0)


def test_every_rung_covers_only_rungs_below_it_and_each_has_its_own_name() -> None:
    below: set[str] = set()
    rungs = ladder(500.0, limits.GAP_S, limits.AGE_DEFAULT_S, 500.0)
    assert max(Counter(rung.name for rung in rungs).values()) == 1
    for rung in rungs:
        for parts in rung.covers:
            assert parts.keys() <= below, rung.name
        below.add(rung.name)


def test_the_ladder_has_the_times_that_sites_and_devices_use() -> None:
    assert session_client.SILENCE_NS == session_server.SILENCE_NS == round(table.SESSION_SILENCE_S * 1e9)
    assert setpoints.STOP_S == table.RETREAT_AFTER_S
    assert exoskeleton.RELEASE_S == table.FORCE_FALL_S
    for stream in STREAMS.values():
        assert not stream.latest_only or stream.rate_hz >= table.SLOWEST_RATE_HZ


@pytest.mark.parametrize(("time_s", "text"), [(0.1, "100 ms"), (1.0, "1 s"), (0.002, "2 ms"), (5.0, "5 s")])
def test_times_are_readable(time_s: float, text: str) -> None:
    assert in_ms(time_s) == text
    assert re.fullmatch(r"[\d.]+ m?s", in_ms(time_s))
