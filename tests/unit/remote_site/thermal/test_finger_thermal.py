"""The start of a live touch, from readings that came irregularly before it."""

from unittest.mock import Mock

import pytest

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from common.fingers import FINGERS
from remote_site.devices.sensor_frame import PlateReading, SensorFrame
from remote_site.thermal.finger_thermal import FingerThermal
from remote_site.thermal.thermal_identification import ThermalKnowledge
from tests.unit.remote_site.made_touches import AMBIENT_C

PERIOD_S = 0.002
CONTACT_S = 2.0
SLOPE_K_S = -0.5
FIVE = len(FINGERS)


@pytest.mark.parametrize("every_ms", [10, 20, 40])
def test_the_slope_before_contact_is_in_kelvin_a_second_where_readings_were_overtaken(
    knowledge: ThermalKnowledge, every_ms: int
) -> None:
    """A slow tick reads the newest reading only: those that remain are farther apart than the sensor's 10 ms."""
    hand = HandMotion()
    exploration, finger = ModeDetector(hand), FingerThermal(0, knowledge)
    finger.own.start = Mock(wraps=finger.own.start)  # type: ignore[method-assign]
    for tick in range(round((CONTACT_S + 0.1) / PERIOD_S)):
        t_s = PERIOD_S * tick
        reading = None
        if 2 * tick % every_ms == 0:
            reading = PlateReading(33.0 + SLOPE_K_S * (t_s - CONTACT_S), AMBIENT_C, "", 2000 * tick, 0)
        force_n = 1.0 if t_s >= CONTACT_S else 0.0
        plates = (reading,) * FIVE
        sensed = SensorFrame(t_s, 0.0, 0.0, (0.0,) * FIVE, (force_n,) * FIVE, (None,) * FIVE, plates, None)
        hand.step(t_s, 0.0, 0.0)
        exploration.step(t_s, force_n, 0.0)
        finger.step(sensed, exploration)
    _, start_c, slope_k_s, *_ = finger.own.start.call_args.args
    assert slope_k_s == pytest.approx(SLOPE_K_S, abs=1e-6)
    assert start_c == pytest.approx(33.0, abs=0.05)


def test_a_touch_elsewhere_after_a_tap_starts_from_readings_after_it(knowledge: ThermalKnowledge) -> None:
    """The tap cools the plate by 1 K; a line through readings before and after it would have a slope."""
    hand = HandMotion()
    exploration, finger = ModeDetector(hand), FingerThermal(0, knowledge)
    finger.own.start = Mock(wraps=finger.own.start)  # type: ignore[method-assign]
    for tick in range(round(2.3 / PERIOD_S)):
        t_s = PERIOD_S * tick
        touches, x_m = 2.0 <= t_s < 2.05 or t_s >= 2.2, 0.03 * (t_s >= 2.1)
        reading = None
        if tick % 5 == 0:
            reading = PlateReading(min(33.0, max(32.0, 33.0 - 20.0 * (t_s - 2.0))), AMBIENT_C, "", 2000 * tick, 0)
        force_n = 1.0 if touches else 0.0
        plates = (reading,) * FIVE
        sensed = SensorFrame(t_s, x_m, 0.0, (0.0,) * FIVE, (force_n,) * FIVE, (None,) * FIVE, plates, None)
        hand.step(t_s, x_m, 0.0)
        exploration.step(t_s, force_n, 0.0)
        finger.step(sensed, exploration)
    starts = [call.args for call in finger.own.start.call_args_list]
    assert [start_c for _, start_c, *_ in starts] == pytest.approx([33.0, 32.0], abs=0.05)
    assert [slope_k_s for _, _, slope_k_s, *_ in starts] == pytest.approx([0.0, 0.0], abs=0.2)
