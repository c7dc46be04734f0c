"""Sound plates are never a fault in any touch, with noisy thermistors and drives that act late."""

import math
from collections import deque
from typing import Literal

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
from operator_site.safety.gated_output import GatedOutput
from operator_site.safety.limit_flags import Limit
from sim_sensors.devices.tacttip import ntc_counts
from sim_sensors.physics.finger_plate import FingerPlates
from tests.virtual.session import COARSE_TICK_S, TICK_S

pytestmark = pytest.mark.long

CYCLES, LEAST_S = 3.0, 18.0
"""Number of touches, and minimum length of a test, s."""
LATE_S = 0.1
NOISE_K = 0.1
READ_EVERY_S = 0.01
HOT = 3
"""Finger on copper of 60 C."""
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


class Plates:
    """Plates of five fingers, driven by the rendering of what they touch.

    Attributes:
        output: last output of the gate.
    """

    def __init__(self, profile: Literal["comfort", "wide"], tick_s: float = TICK_S) -> None:
        self.plates = FingerPlates(N, 0, NOISE_K)
        self._rendering = GatedRendering(RenderingConfig(profile=profile), tick_s, GAP_S)
        self._tick_s, self._ticks = tick_s, 0
        self._sensors = [PlateSensor() for _ in range(N)]
        self._on_its_way = deque([np.zeros(N)] * round(LATE_S / tick_s))
        self._plate_c, self._read_s = (math.nan,) * N, -math.inf
        self.output: GatedOutput

    @property
    def time_s(self) -> float:
        """Time since the begin, s."""
        return self._ticks * self._tick_s

    def step(self, given: Touch, *, pressed: bool) -> None:
        """Let one tick pass, with all fingers pressed down or up."""
        self._ticks += 1
        now_s = self.time_s
        self.plates.step(self._tick_s, self._on_its_way.popleft())
        if now_s - self._read_s >= READ_EVERY_S - 1e-6:
            read = zip(self._sensors, self.plates.ntc_c.tolist(), strict=True)
            self._plate_c = tuple(sensor.step(now_s, ntc_counts(c)).plate_c for sensor, c in read)
            self._read_s = now_s
        z_m, ages_s = (-0.004 if pressed else 0.01,) * N, (now_s - self._read_s,) * N
        place = (0.0, 0.0, z_m, now_s, now_s)
        now = RenderingInput(now_s, 7, False, True, 0, given.sequence, *place, self._plate_c, ages_s, ())
        self.output = self._rendering.step(now, given)
        assert self.output.fault is None
        self._on_its_way.append(np.array(self.output.peltier_drive))


@pytest.mark.parametrize("material", list(OBJECTS_C))
@pytest.mark.parametrize("profile", ["comfort", "wide"])
@pytest.mark.parametrize("dwell_s", [3.0, *(pytest.param(each, marks=pytest.mark.hardening) for each in (0.4, 10.0))])
def test_no_touch_makes_a_sound_plate_faulty(
    profile: Literal["comfort", "wide"], material: str, dwell_s: float
) -> None:
    tips = Plates(profile)
    coldest_c, hottest_c = math.inf, -math.inf
    free, pressed = touch(material, pressed=False), touch(material, pressed=True)
    for tick in range(1, round(max(CYCLES * 2.0 * dwell_s, LEAST_S) / TICK_S)):
        touching = tick * TICK_S % (2.0 * dwell_s) < dwell_s
        tips.step(pressed if touching else free, pressed=touching)
        plate_c = tips.plates.plate_c
        coldest_c, hottest_c = min(coldest_c, plate_c.min()), max(hottest_c, plate_c.max())
    assert coldest_c < 31.0  # the plates did something
    assert hottest_c - coldest_c > 3.0


def test_a_plate_whose_dose_was_spent_does_not_heat_a_finger_that_has_left() -> None:
    tips = Plates("wide", COARSE_TICK_S)
    free, pressed = touch("copper", pressed=False), touch("copper", pressed=True)
    spent = False
    while not spent and tips.time_s < 30.0:
        tips.step(pressed, pressed=True)
        spent = bool(tips.output.limited[HOT] & Limit.DOSE)
    assert spent
    while spent and tips.time_s < 120.0:
        tips.step(free, pressed=False)
        spent = bool(tips.output.limited[HOT] & Limit.DOSE)
    assert not spent
    until_s = tips.time_s + 5.0
    while tips.time_s < until_s:
        tips.step(free, pressed=False)
        assert tips.plates.plate_c[HOT] < 34.5
