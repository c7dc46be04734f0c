"""One finger from approach to lift: modes, events, heater and thermal answer."""

from pathlib import Path

import numpy as np
import pytest

from common.messages import ExplorationMode, ThermalStatus
from remote_site.finger_identification import FingerIdentification, FingerSample
from remote_site.material_table import MaterialTable
from remote_site.surface_class import SurfaceTable

TABLES = Path(__file__).parents[2] / "remote_site" / "tables"


@pytest.fixture(scope="module")
def tables():
    return MaterialTable.load(TABLES / "materials.json"), SurfaceTable.load(TABLES / "surfaces.json")


def explore(tables, sensor, stroke_from=99.0, seconds=9.5, fault=None, lift_s=9.2):
    finger = FingerIdentification(1, *tables)
    rng = np.random.default_rng(0)
    touches = []
    for k in range(round(500 * seconds)):
        t = 0.002 * k
        touching = 0.5 <= t < lift_s
        x = 0.05 * max(0.0, t - stroke_from)
        touches.append(
            finger.step(
                FingerSample(
                    t,
                    1.2 if touching else 0.0,
                    x,
                    0.0,
                    -3e-4 if touching else 0.02 * max(0.5 - t, 0.0),
                    0.012 * rng.normal(size=10) if k % 5 < 2 else None,
                    sensor(t) if k % 5 == 0 else None,
                    23.0 if k % 5 == 0 else None,
                    fault if t > 2.0 else None,
                )
            )
        )
    return finger, touches


def aluminium(t):
    return 33.0 - 9.0 * (1.0 - np.exp(-max(0.0, t - 0.5) / 1.5))


def test_a_tap_is_told_once_with_its_speed(tables):
    _, touches = explore(tables, lambda t: 33.0)
    taps = [event for touch in touches for event in touch.events if event.kind == "tap"]
    assert [event.value for event in taps] == pytest.approx([0.02], abs=0.005)


def test_the_heater_is_off_in_contact(tables):
    _, touches = explore(tables, lambda t: 25.0)
    assert touches[100].heater_drive == 1.0
    assert all(touch.heater_drive == 0.0 for touch in touches if touch.contact)


def test_body_warm_objects_ask_for_another_preheat(tables):
    finger, touches = explore(tables, lambda t: 33.0)
    answer = touches[4500].thermal
    assert answer.status is ThermalStatus.UNIDENTIFIABLE
    assert touches[4500].conductivity_w_mk == 0.0
    assert finger.preheat_k == 17.0
    assert touches[-1].thermal.status is ThermalStatus.NO_CONTACT


def test_stroking_ends_the_thermal_touch(tables):
    _, touches = explore(tables, aluminium, stroke_from=1.0)
    assert touches[2000].mode is ExplorationMode.STROKING
    assert touches[2000].thermal.reason == "stroked: the touch did not rest"


def test_a_sensor_fault_ends_the_thermal_touch(tables):
    _, touches = explore(tables, aluminium, fault="thermal sensor open")
    assert "thermal sensor open" in (touches[2000].thermal.reason or "")
    assert touches[-1].heater_drive == 0.0
