"""Pre-heating of several plates, by their identification."""

import math
from types import SimpleNamespace
from typing import Any

import pytest

from common.fingers import FINGERS
from common.limits import SENSOR_PLATE_C
from common.wire.messages import ThermalReason
from remote_site.devices.sensor_frame import PlateReading, SensorFrame
from remote_site.heating import FingerHeating, Heating
from remote_site.thermal.heater_control import GAIN_PER_K, OFFSETS_K, STAGGER_K, STALE_S, next_offset_k
from tests.unit.remote_site.made_touches import AMBIENT_C
from tests.unit.remote_site.shipped_tables import perception

PREHEATS_K = [OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K]
REST, NONE = (0.0,) * len(FINGERS), (None,) * len(FINGERS)


def cool(under_k: float = 1.0, fault: str = "") -> tuple[PlateReading, ...]:
    """Plates that are this far below their first set-points, K."""
    return tuple(PlateReading(AMBIENT_C + preheat_k - under_k, AMBIENT_C, fault, 0, 0) for preheat_k in PREHEATS_K)


def sensed(t_s: float, plates: tuple[PlateReading | None, ...]) -> SensorFrame:
    return SensorFrame(t_s, 0.0, 0.0, REST, REST, NONE, plates, None)


def identified(no_differences: int) -> dict[int, Any]:
    """Identification of a free thumb after some touches without a temperature difference."""
    return {0: SimpleNamespace(thermal=SimpleNamespace(measuring=False, no_differences=no_differences))}


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_session_staggers_its_fingers(count: int) -> None:
    """Each heater heats a plate that is 1 K below its own pre-heat as it should."""
    perceived, heating, now = perception(FINGERS[:count]), Heating(FINGERS[:count]), sensed(1.0, cool())
    perceived.step(now)
    drives = heating.step(now, perceived.touches)
    assert drives == pytest.approx([GAIN_PER_K] * count + [0.0] * (len(FINGERS) - count))


def test_a_plate_is_heated_while_its_finger_is_free_and_not_in_a_touch() -> None:
    heating = FingerHeating(OFFSETS_K[0])
    assert heating.step(1.0, cool(5.0)[0], False, 0) == 1.0
    assert heating.step(1.002, None, False, 0) == 1.0, "until the next reading"
    assert heating.step(1.004, None, True, 0) == 0.0
    assert heating.step(1.010, cool(5.0)[0], True, 0) == 0.0, "it may bounce"
    assert heating.step(1.020, cool(5.0)[0], False, 0) == 1.0


def test_a_missing_or_implausible_reading_heats_nothing() -> None:
    heating = FingerHeating(OFFSETS_K[0])
    assert heating.step(1.0, cool(5.0)[0], False, 0) == 1.0
    assert heating.step(0.998 + STALE_S, None, False, 0) == 1.0
    assert heating.step(1.002 + STALE_S, None, False, 0) == 0.0
    assert heating.step(2.0, cool(5.0, ThermalReason.SENSOR_OPEN.code)[0], False, 0) == 0.0


@pytest.mark.parametrize("preheat_k", sorted(set(PREHEATS_K)))
def test_an_object_as_warm_as_the_plate_asks_for_another_preheat(preheat_k: float) -> None:
    heating = FingerHeating(preheat_k)
    heating.step(1.0, cool()[0], False, 0)
    heating.step(1.002, None, False, 1)
    assert heating.control.offset_k == next_offset_k(preheat_k, AMBIENT_C)
    assert abs(heating.control.offset_k - preheat_k) >= 3.0
    assert AMBIENT_C + heating.control.offset_k < SENSOR_PLATE_C
    heating.step(1.004, None, False, 1)
    assert heating.control.offset_k == next_offset_k(preheat_k, AMBIENT_C), "once for each touch"


def test_no_preheat_is_chosen_before_the_ambient_temperature_is_known() -> None:
    heating = FingerHeating(OFFSETS_K[0])
    heating.step(1.0, None, False, 1)
    assert heating.control.offset_k == OFFSETS_K[0]


@pytest.mark.parametrize("again_s", [0.5, math.inf], ids=["clock set back", "identification failed"])
def test_heating_restarts_with_identification(again_s: float) -> None:
    heating = Heating(FINGERS[:1])
    heating.step(sensed(1.0, cool()), identified(no_differences=1))
    if again_s == math.inf:
        assert heating.step(sensed(1.002, cool()), {}) == [0.0] * len(FINGERS)
        again_s = 2.0
    drives = heating.step(sensed(again_s, cool()), identified(no_differences=0))
    assert drives[0] == pytest.approx(GAIN_PER_K), "at the first pre-heat again"
