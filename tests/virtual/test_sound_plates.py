"""Sound plates are never a fault in any touch, with noisy thermistors and drives that act late."""

import math
from collections import deque

import numpy as np
import pytest

from common.config.site_models import RenderingConfig
from common.limits import GAP_S
from common.scenes.materials import materials
from common.wire.messages import NO_TOUCH, ExplorationMode, Touch, pack_rows
from common.wire.packets import LinkState, N
from operator_site.devices.ntc import PlateSensor
from operator_site.gated_rendering import GatedRendering
from operator_site.recorded_rows import RenderingInput
from sim_sensors.devices.tacttip import ntc_counts
from sim_sensors.physics.finger_plate import FingerPlates
from tests.virtual.session import TICK_S

pytestmark = pytest.mark.long

CYCLES, LEAST_S = 3.0, 18.0
"""Number of touches, and minimum length of a test, s."""
LATE_S = 0.1
NOISE_K = 0.1
READ_EVERY = 5
OBJECTS_C = {"copper": (-10.0, 36.0, 40.0, 60.0, 90.0), "aluminium": (-10.0, 5.0, 15.0, 25.0, 33.0)}


def touch(material: str, *, pressed: bool) -> Touch:
    """All fingers on, or free of, objects of one material, each of another temperature."""
    known = materials()[material]
    row = NO_TOUCH._replace(
        mode=ExplorationMode.TAPPING,
        contact=pressed,
        stiffness_n_m=300.0 * pressed,
        conductivity_w_mk=known.conductivity_w_mk,
        density_kg_m3=known.density_kg_m3,
        specific_heat_j_kgk=known.specific_heat_j_kgk,
    )
    floats = pack_rows(row._replace(object_c=object_c) for object_c in OBJECTS_C[material])
    return Touch(7, 1 + pressed, 1, LinkState.ENGAGED, floats, ("",) * N, ())


@pytest.mark.parametrize("material", list(OBJECTS_C))
@pytest.mark.parametrize("profile", ["comfort", "wide"])
@pytest.mark.parametrize("dwell_s", [3.0, *(pytest.param(each, marks=pytest.mark.hardening) for each in (0.4, 10.0))])
def test_no_touch_makes_a_sound_plate_faulty(profile: str, material: str, dwell_s: float) -> None:
    rendering = GatedRendering(RenderingConfig(profile=profile), 0.002, GAP_S)  # type: ignore[arg-type]
    plates = FingerPlates(N, 0, NOISE_K)
    sensors = [PlateSensor() for _ in range(N)]
    on_its_way = deque([np.zeros(N)] * round(LATE_S / TICK_S))
    free, pressed = touch(material, pressed=False), touch(material, pressed=True)
    plate_c, read_s, coldest_c, hottest_c = (math.nan,) * N, -math.inf, math.inf, -math.inf
    for tick in range(1, round(max(CYCLES * 2.0 * dwell_s, LEAST_S) / TICK_S)):
        now_s = tick * TICK_S
        plates.step(TICK_S, on_its_way.popleft())
        if tick % READ_EVERY == 0:
            read = zip(sensors, plates.ntc_c.tolist(), strict=True)
            plate_c, read_s = tuple(sensor.step(now_s, ntc_counts(c)).plate_c for sensor, c in read), now_s
        touching = now_s % (2.0 * dwell_s) < dwell_s
        z_m = (-0.004 if touching else 0.01,) * N
        given = pressed if touching else free
        ages_s = (now_s - read_s,) * N
        now = RenderingInput(now_s, 7, False, True, 0, given.sequence, 0.0, 0.0, z_m, now_s, now_s, plate_c, ages_s, ())
        output = rendering.step(now, given)
        assert output.fault is None
        on_its_way.append(np.array(output.peltier_drive))
        coldest_c, hottest_c = min(coldest_c, plates.plate_c.min()), max(hottest_c, plates.plate_c.max())
    assert coldest_c < 31.0  # the plates did something
    assert hottest_c - coldest_c > 3.0
