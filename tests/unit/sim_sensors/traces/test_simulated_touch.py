"""Touches of several fingers on one object, and contacts that change."""

import math

import numpy as np
import pytest

from sim_sensors.traces.simulated_touch import simulate_hand, simulate_thermal


def test_fingers_of_a_hand_share_the_object_and_nothing_else() -> None:
    hands = simulate_hand("pine", 3, (10.0, 14.0, 6.0), touches=2, seconds=1.0)
    assert [len(hand) for hand in hands] == [3, 3]
    for hand in hands:
        assert len({trace.object_c for trace in hand}) == 1
        assert len({trace.conductance_w_m2k for trace in hand}) == 3
        before_c = [float(trace.sensor_c[60:70].mean()) - 23.0 for trace in hand]
        assert before_c == pytest.approx([10.0, 14.0, 6.0], abs=0.5)
    assert hands[0][0].object_c != hands[1][0].object_c


@pytest.mark.long
def test_a_finger_that_is_lifted_stops_conducting_and_one_that_presses_conducts_more() -> None:
    def fallen_k(later: tuple[float, float] | None) -> float:
        (trace,) = simulate_thermal("aluminium", 7, seconds=2.0, later=later)
        begin, end = (int(np.searchsorted(trace.time_s, trace.contact_s + since_s)) for since_s in (1.0, 2.0))
        return float(trace.sensor_c[begin] - trace.sensor_c[end - 1])

    lifted, steady, pressed = fallen_k((0.5, 0.0)), fallen_k(None), fallen_k((0.5, 3.0))
    assert lifted < 0.5 * steady
    assert pressed > steady
    (trace,) = simulate_thermal("aluminium", 7, seconds=2.0, later=(0.5, 0.0))
    assert np.abs(trace.force_n[trace.time_s > trace.contact_s + 0.6]).max() < 0.1


@pytest.mark.long
def test_contacts_scatter_with_the_given_spread() -> None:
    for spread in (0.05, 0.5):
        traces = simulate_thermal("aluminium", 1, touches=200, seconds=0.1, contact_spread=spread)
        found = np.std(np.log([trace.conductance_w_m2k for trace in traces]))
        assert found == pytest.approx(spread, rel=0.3)


@pytest.mark.parametrize("preheat_k", [-1.0, 19.1, 1000.0, math.nan, math.inf])
def test_a_preheating_beyond_the_heater_is_refused(preheat_k: float) -> None:
    with pytest.raises(ValueError, match=r"pre-heating, K must be 0\.\.19"):
        simulate_thermal("pine", 1, preheat_k=preheat_k)


@pytest.mark.parametrize("offset_c", [(math.nan, 3.0), (-3.0, math.inf), (-34.0, 0.0), (0.0, 38.0)])
def test_an_impossible_temperature_of_the_object_is_refused(offset_c: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match=r"object, C must be -10\.\.60"):
        simulate_thermal("pine", 1, offset_c=offset_c)


@pytest.mark.parametrize("preheats_k", [(), (10.0,) * 6])
def test_a_hand_has_one_to_five_fingers(preheats_k: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="fingers"):
        simulate_hand("pine", 1, preheats_k)
