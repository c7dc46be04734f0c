"""Plates of different warmth on one hand, and the next pre-heat after an object without difference."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from common.fingers import FINGERS
from common.hand_motion import HandMotion
from common.limits import SENSOR_PLATE_C
from common.messages import ThermalStatus
from remote_site.finger_identification import FingerIdentification
from remote_site.finger_touch import FingerSample
from remote_site.heater_control import OFFSETS_K, STAGGER_K, HeaterControl, next_offset_k
from remote_site.perception import Perception
from remote_site.surface_class import SurfaceTable
from remote_site.thermal_answer import NO_DIFFERENCE
from remote_site.thermal_identification import ThermalKnowledge
from tests.remote_site.made_touches import AMBIENT_C, true_table

SURFACES = SurfaceTable.load(Path(__file__).parents[2] / "remote_site" / "tables" / "surfaces.json")


def warmed(offset_k: float) -> float:
    """Where a plate of 5.2 K/s at full drive comes to rest at AMBIENT_C, C."""
    control, plate_c, read_c = HeaterControl(offset_k), AMBIENT_C, AMBIENT_C
    for k in range(1500):
        drive = control.step(0.01 * k, read_c, AMBIENT_C, False)
        plate_c += 0.01 * (5.2 * drive - 0.03 * (plate_c - AMBIENT_C))
        read_c += 0.01 / 0.3 * (plate_c - read_c)
    return plate_c


def test_there_is_a_difference_between_any_two_neighbours_and_one_for_each_finger() -> None:
    assert len(STAGGER_K) == len(FINGERS)
    assert all(abs(a - b) >= 3.0 for a, b in pairwise(STAGGER_K))
    assert all(offset + OFFSETS_K[0] >= 3.0 for offset in STAGGER_K)


@pytest.mark.parametrize("offset_k", sorted({OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K}))
def test_the_plates_really_come_to_different_temperatures(offset_k: float) -> None:
    assert warmed(offset_k) == pytest.approx(AMBIENT_C + offset_k, abs=0.2)
    assert warmed(offset_k) < SENSOR_PLATE_C


@pytest.mark.parametrize("fingers", [FINGERS[:1], FINGERS[:2], FINGERS])
def test_a_session_staggers_its_fingers(fingers: tuple[str, ...]) -> None:
    perception = Perception(fingers, true_table(), SURFACES)
    offsets_k = [each.heat.preheat_k for each in perception._identifications.values()]
    assert offsets_k == [OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K[: len(fingers)]]


@pytest.mark.parametrize("preheat_k", sorted({OFFSETS_K[0] + stagger_k for stagger_k in STAGGER_K}))
def test_an_object_as_warm_as_the_plate_asks_for_another_preheat(knowledge: ThermalKnowledge, preheat_k: float) -> None:
    finger = FingerIdentification(1, knowledge, SURFACES, HandMotion(), preheat_k)
    rng = np.random.default_rng(0)
    statuses = set()
    for k in range(1500):
        t_s = 0.002 * k
        touching = 0.5 <= t_s < 2.5
        sensor_c = AMBIENT_C + preheat_k + 0.02 * rng.normal() if k % 5 == 0 else None
        ambient_c = AMBIENT_C if k % 5 == 0 else None
        sample = FingerSample(t_s, 1.2 if touching else 0.0, 0.0, 0.0, 0.0, None, sensor_c, ambient_c)
        thermal = finger.step(sample).thermal
        finger.heat.thermal.work()
        statuses.add((thermal.status, thermal.reason))
    assert (ThermalStatus.UNIDENTIFIABLE, NO_DIFFERENCE) in statuses
    assert finger.heat.preheat_k == next_offset_k(preheat_k, AMBIENT_C)
    assert abs(finger.heat.preheat_k - preheat_k) >= 3.0
    assert AMBIENT_C + finger.heat.preheat_k < SENSOR_PLATE_C
