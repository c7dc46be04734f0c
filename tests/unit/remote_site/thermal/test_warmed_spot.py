"""A plate that lands where it has just been."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.fingers import FINGERS
from common.wire.messages import ThermalReason, ThermalStatus
from remote_site.thermal.warmed_spot import LONGEST_S, SPOT_M, TRACES, WARM, WarmedSpot
from tests.unit.remote_site.landings import Landing, land, named

TRUE = {"aluminium": "aluminium", "ceramic": "ceramic_tile", "wood": "pine", "pvc_plain": "pvc"}
THUMB = FINGERS[:1]
STUMBLED = (Landing(0.3, 0.16), Landing(0.45, 0.01), Landing(0.4, 0.01), Landing(0.2, 0.03), Landing(2.5))
"""A hand that a stalled machine takes back and lets down again."""


def pressed(for_s: float, tick_s: float = 0.01) -> WarmedSpot:
    """A spot that was pressed from 0 s on."""
    spot = WarmedSpot()
    for tick in range(round(for_s / tick_s) + 1):
        spot.press(tick_s * tick, 0.0, 0.0, began=tick == 0)
    return spot


@given(for_s=st.floats(0.1, LONGEST_S), pauses=st.floats(0.0, 100.0))
def test_the_remaining_warmth_follows_from_touch_and_pause_alone(for_s: float, pauses: float) -> None:
    for_s = round(for_s, 2)
    left = pressed(for_s).left(for_s * (1.0 + pauses), 0.0, 0.0)
    assert left == pytest.approx(math.sqrt(1.0 + pauses) - math.sqrt(pauses), abs=1e-6)


def test_a_spot_is_warm_for_three_times_the_touch_and_leaves_traces_for_thirty() -> None:
    spot = pressed(1.0)
    assert [spot.left(1.0 + pause_s, 0.0, 0.0) > WARM for pause_s in (0.0, 2.9, 3.1)] == [True, True, False]
    assert [spot.left(1.0 + pause_s, 0.0, 0.0) > TRACES for pause_s in (3.1, 29.0, 31.0)] == [True, True, False]


def test_a_long_touch_warms_no_further() -> None:
    assert pressed(60.0, 0.1).left(90.0, 0.0, 0.0) == pytest.approx(pressed(LONGEST_S).left(LONGEST_S + 30.0, 0.0, 0.0))


def test_beside_the_spot_and_before_any_touch_nothing_is_left() -> None:
    assert WarmedSpot().left(0.0, 0.0, 0.0) == 0.0
    assert pressed(1.0).left(1.0, 1.1 * SPOT_M, 0.0) == 0.0


def test_a_finger_that_slides_on_warms_where_it_is_now() -> None:
    spot = pressed(5.0)
    spot.press(5.01, 2.0 * SPOT_M, 0.0, began=False)
    spot.press(5.11, 2.0 * SPOT_M, 0.0, began=False)
    assert spot.left(5.5, 0.0, 0.0) == 0.0
    assert spot.left(5.5, 2.0 * SPOT_M, 0.0) == pytest.approx(math.sqrt(4.9) - math.sqrt(3.9))


def test_touches_that_follow_each_other_at_once_add_up() -> None:
    spot = WarmedSpot()
    for tap in range(10):
        for tick in range(11):
            spot.press(0.15 * tap + 0.01 * tick, 0.0, 0.0, began=tick == 0)
    assert spot.left(1.45 + 2.9, 0.0, 0.0) > WARM > spot.left(1.45 + 3.1, 0.0, 0.0)


@pytest.mark.long
@pytest.mark.parametrize("name", TRUE)
def test_a_stumbling_finger_is_not_misled_by_its_own_warmth(name: str) -> None:
    moments = land(name, STUMBLED, fingers=THUMB)
    assert named(moments) <= {TRUE[name]}
    last = moments[-200].touches[0].thermal
    assert (last.status, last.reason) == (ThermalStatus.UNIDENTIFIABLE, ThermalReason.STILL_WARM)


@pytest.mark.long
@pytest.mark.parametrize("name", TRUE)
def test_a_hand_that_returns_keeps_its_result_and_is_not_misled_by_its_traces(name: str) -> None:
    """Before spots were remembered, five fingers named every PVC pine that they touched again."""
    moments = land(name, (Landing(3.0, 0.5), Landing(1.0, 13.0), Landing(4.0, 0.1)))
    again = [moment for moment in moments if moment.landing == 1 and moment.touches[0].contact]
    assert named(moments, 0) == {TRUE[name]}
    for moment in again[10:-10]:
        for touch in moment.touches.values():
            assert (touch.thermal.material, touch.thermal.reason) == (TRUE[name], ThermalReason.TOUCHED_BEFORE)
    assert named(moments, 2) <= {TRUE[name]}
    assert {touch.thermal.status for touch in moments[-150].touches.values()} <= {
        ThermalStatus.DECIDING,
        ThermalStatus.IDENTIFIED,
        ThermalStatus.AMBIGUOUS,
    }


@pytest.mark.long
@pytest.mark.parametrize("name", ["aluminium", "ceramic"])
def test_a_hand_beside_the_last_spot_starts_a_new_identification(name: str) -> None:
    moments = land(name, (Landing(2.0, 2.5), Landing(3.0, beside_m=0.03)))
    assert named(moments, 1) == {TRUE[name]}
    reasons = {touch.thermal.reason for moment in moments if moment.landing == 1 for touch in moment.touches.values()}
    assert ThermalReason.TOUCHED_BEFORE not in reasons
    assert ThermalReason.STILL_WARM not in reasons


@pytest.mark.long
@pytest.mark.parametrize("name", TRUE)
def test_a_finger_that_bounces_as_it_lands_touches_once(name: str) -> None:
    moments = land(name, (Landing(0.02, 0.03), Landing(5.0)))
    assert named(moments) == {TRUE[name]}
    began = [b.time_s for a, b in pairwise(moments) if b.touches[0].contact > a.touches[0].contact]
    assert len(began) == 2, "the hand did not bounce"
    assert {moments[-100].touches[finger].thermal.reason for finger in range(5)} == {ThermalReason.NONE}


@pytest.mark.long
def test_the_heater_waits_for_a_finger_that_may_bounce_and_warms_the_plate_of_one_that_left() -> None:
    tapped, left = (land("ceramic", (Landing(down_s, 0.4),), fingers=THUMB) for down_s in (0.05, 0.4))
    for moments, drives in ((tapped, False), (left, True)):
        lift_s = max(moment.time_s for moment in moments if moment.touches[0].contact)
        after = [moment.drive[0] for moment in moments if 0.05 < moment.time_s - lift_s < 0.3]
        assert any(drive > 0.0 for drive in after) is drives
