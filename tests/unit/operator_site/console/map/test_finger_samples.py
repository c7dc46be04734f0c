"""Samples from a finger's packets: a rest one temperature, a press one stiffness, a stroke the roughness of its way."""

import math
from itertools import pairwise

import pytest

from common.wire.messages import NO_TOUCH, ExplorationMode, ThermalStatus
from common.wire.touch_summary import NOTHING, TouchSummary
from operator_site.console.map.finger_samples import (
    DWELL_EVERY_S,
    DWELL_S,
    FIRST_M,
    LATE_M,
    LEAST_VARIANCE,
    STILL_M,
    STROKE_STEP_M,
    FingerSamples,
    Sample,
)
from tests.unit.operator_site.console.touch_rows import INDEX, row

STROKING = float(ExplorationMode.STROKING)


def rest(samples: FingerSamples, seconds: float, drift_m_s: float = 0.0, **fields: float) -> list[Sample]:
    """A finger that comes down at (0.010, 0.020) and stays there or drifts."""
    found = []
    for tick in range(round(seconds / 0.01)):
        x_m = 0.010 + drift_m_s * 0.01 * tick
        found += samples.step(0.01 * tick, row(INDEX, x_m, 0.020, **fields), NOTHING)
    return found


def stroke(
    samples: FingerSamples, length_m: float, border_m: float = math.inf, speed_m_s: float = 0.05
) -> list[Sample]:
    """A stroke along x from 0; the site reports 0.1 V instead of 0.005 V from 5 mm beyond the border on."""
    found, summary, tick = [], NOTHING, 0
    while (x_m := speed_m_s * 0.002 * tick) <= length_m:
        if tick % 50 == 0:
            roughness_v = 0.1 if x_m - 5e-3 > border_m else 0.005
            summary = TouchSummary((), roughness_v + 1e-7 * tick, 0.07 * roughness_v)
        found += samples.step(0.002 * tick, row(INDEX, x_m, 0.0, mode=STROKING), summary)
        tick += 1
    return found


def test_a_rest_gives_one_temperature_that_is_replaced_while_it_lasts() -> None:
    found = rest(FingerSamples(INDEX), 2.0, object_c=36.4, object_c_sd=0.2)
    assert len(found) == pytest.approx((2.0 - DWELL_S) / DWELL_EVERY_S, abs=2)
    assert {(s.quantity, s.key) for s in found} == {("temperature", (INDEX, 1, 0))}
    assert (found[-1].x_m, found[-1].y_m, found[-1].value) == pytest.approx((0.010, 0.020, 36.4))
    assert found[-1].variance == pytest.approx(0.04)
    certain = rest(FingerSamples(INDEX), 2.0, object_c=36.4, object_c_sd=0.0)
    assert {one.variance for one in certain} == {LEAST_VARIANCE}, "none is believed without bounds"


def test_a_leaving_finger_gives_no_stiffness() -> None:
    samples, found = FingerSamples(INDEX), []
    for tick in range(100):
        force_n = min(1.0, 0.05 * tick, 0.05 * (100 - tick))
        stiffness_n_m = 600.0 if tick > 50 and force_n < 0.7 else 400.0
        pressed = {"contact_force_n": force_n, "stiffness_n_m": stiffness_n_m, "stiffness_ln_sd": 0.03}
        found += samples.step(0.01 * tick, row(INDEX, 0.010, 0.020, **pressed), NOTHING)
    assert {round(math.exp(sample.value)) for sample in found} == {400}


def test_another_contact_is_another_touch() -> None:
    samples = FingerSamples(INDEX)
    first = rest(samples, 1.8, object_c=36.4, object_c_sd=0.2)
    assert samples.step(2.0, NO_TOUCH, NOTHING) == []
    second = rest(samples, 1.8, object_c=36.4, object_c_sd=0.2)
    assert first[0].key != second[0].key


def test_a_sliding_finger_gives_no_temperature_beyond_its_place() -> None:
    found = rest(FingerSamples(INDEX), 4.0, drift_m_s=1e-3, object_c=36.4, object_c_sd=0.2)
    assert found
    assert max(s.t_s for s in found) <= STILL_M / 1e-3
    assert {s.x_m for s in found} == {0.010}


@pytest.mark.parametrize(
    ("seconds", "fields"),
    [
        (DWELL_S - 0.05, {}),
        (3.0, {"object_c_sd": 2.1}),
        (3.0, {"thermal_status": float(ThermalStatus.NO_CONTACT)}),
        (1.0, {"mode": STROKING, "stiffness_n_m": 600.0, "stiffness_ln_sd": 0.03}),
    ],
    ids=["too short", "not known", "no contact", "a stroke, nor stiffness"],
)
def test_where_a_temperature_is_not_known_none_is_sampled(seconds: float, fields: dict[str, float]) -> None:
    assert rest(FingerSamples(INDEX), seconds, **({"object_c": 36.4, "object_c_sd": 0.2} | fields)) == []


def test_a_press_gives_stiffness_once_it_is_known() -> None:
    assert rest(FingerSamples(INDEX), 1.0, stiffness_n_m=600.0, stiffness_ln_sd=0.06) == []
    found = rest(FingerSamples(INDEX), 1.0, stiffness_n_m=600.0, stiffness_ln_sd=0.03)
    assert {s.quantity for s in found} == {"stiffness"}
    assert math.exp(found[-1].value) == pytest.approx(600.0)


def test_a_material_counts_where_it_is_identified() -> None:
    samples, summary = FingerSamples(INDEX), TouchSummary((("pvc", 0.99), ("fat", 0.01)))
    identified = row(INDEX, 0.0, 0.0, thermal_status=float(ThermalStatus.IDENTIFIED))
    assert [s for tick in range(5) for s in samples.step(0.1 * tick, row(INDEX, 0.0, 0.0), summary)] == []
    (found,) = samples.step(0.6, identified, summary)
    assert (found.quantity, found.name, found.value) == ("material", "pvc", 0.99)


def test_a_stroke_that_is_too_short_gives_no_roughness() -> None:
    assert stroke(FingerSamples(INDEX), LATE_M - 1e-3) == []
    assert stroke(FingerSamples(INDEX), 0.030)


def test_roughness_lies_where_it_was_measured_not_at_the_finger() -> None:
    found = stroke(FingerSamples(INDEX), 0.060, border_m=0.030)
    smooth = [s.x_m for s in found if math.exp(s.value) < 0.02]
    rough = [s.x_m for s in found if math.exp(s.value) > 0.02]
    assert max(smooth) == pytest.approx(0.030, abs=6e-3)  # 0.1 s of way go by between two reports
    assert min(rough) == pytest.approx(0.030, abs=6e-3)
    assert max(rough) <= 0.060 - LATE_M + STROKE_STEP_M


def test_to_and_fro_the_places_are_as_much_too_early_as_too_late() -> None:
    there = stroke(FingerSamples(INDEX), 0.080, border_m=0.030)
    edge_m = min(s.x_m for s in there if math.exp(s.value) > 0.02)
    assert abs(edge_m - 0.030) <= 0.5 * 0.05 * 0.1 + STROKE_STEP_M


def test_samples_of_a_stroke_stand_one_step_apart() -> None:
    places = [s.x_m for s in stroke(FingerSamples(INDEX), 0.050)]
    steps = [after - before for before, after in pairwise(places)]
    assert steps == pytest.approx([STROKE_STEP_M] * len(steps), abs=1e-6)


def painted_mm(faulty_m: tuple[float, float], length_m: float = 0.3) -> list[tuple[float, float]]:
    """x, mm, and roughness, V, of the samples of a stroke whose sensor is faulty between two places."""
    samples, found, summary = FingerSamples(INDEX), [], NOTHING
    for tick in range(round(length_m / 1e-4)):
        x_m = 1e-4 * tick
        if tick % 50 == 0:
            blind = x_m < 5e-3 or faulty_m[0] <= x_m < faulty_m[1] + 5e-3
            roughness_v = 0.01 if x_m < faulty_m[0] else 0.04
            summary = NOTHING if blind else TouchSummary((), roughness_v + 1e-7 * tick, 0.07 * roughness_v)
        found += samples.step(0.002 * tick, row(INDEX, x_m, 0.0, mode=STROKING), summary)
    return [(1e3 * sample.x_m, round(math.exp(sample.value), 3)) for sample in found]


def test_no_roughness_lies_where_the_sensor_was_faulty() -> None:
    found = painted_mm(faulty_m=(0.100, 0.200))
    assert {roughness_v for x_mm, roughness_v in found if x_mm < 100.0} == {0.01}
    assert {roughness_v for x_mm, roughness_v in found if x_mm > 198.0} == {0.04}
    assert not [x_mm for x_mm, _ in found if 100.0 < x_mm < 198.0], "to the step of the path"
    assert len(found) == pytest.approx((100.0 + 100.0 - 2e3 * LATE_M) / (1e3 * STROKE_STEP_M), abs=5)


def test_a_sensor_that_is_faulty_from_the_begin_of_a_stroke_paints_little_of_it() -> None:
    found = painted_mm(faulty_m=(0.0, 0.200))
    assert min(x_mm for x_mm, _ in found) > 1e3 * (0.200 - FIRST_M)


def test_a_stroke_without_roughness_keeps_little_of_its_path() -> None:
    samples = FingerSamples(INDEX)
    for tick in range(20_000):
        samples.step(0.002 * tick, row(INDEX, 1e-4 * (tick % 3000), 0.0, mode=STROKING), NOTHING)
    assert len(samples._path) < 2.0 * FIRST_M / 0.5e-3
