"""Recorded strokes at the sensor's rate."""

import numpy as np
import pytest

from remote_site.texture.recorded.identify_texture import identify_stroke
from remote_site.traces.trace_files import StrokeTrace
from sim_sensors.traces.simulated_stroke import simulate_stroke
from tests.unit.remote_site.shipped_tables import SURFACES
from tests.unit.remote_site.simulated_strokes import to_and_fro


def test_a_stroke_backwards_has_the_answer_of_one_forwards() -> None:
    made = simulate_stroke("widely_grooved_pvc", 7, 80.0, 1.0)
    forwards, backwards = (
        identify_stroke(
            StrokeTrace(made.time_s, made.pressure_v, made.force_n, direction * 1e-3 * made.speed_mm_s), SURFACES
        )
        for direction in (1.0, -1.0)
    )
    assert forwards == backwards
    assert [part["surface"] for part in forwards if part["mode"] == "stroking"] == ["widely_grooved_pvc"]


def test_no_distance_of_grooves_spans_a_fault_of_the_sensor() -> None:
    made = simulate_stroke("widely_grooved_pvc", 7, 80.0, 1.0, length_m=0.07)
    pressure_v, middle = made.pressure_v.copy(), len(made.time_s) // 2
    pressure_v[middle : middle + 40] = 10.0
    trace = StrokeTrace(made.time_s, pressure_v, made.force_n, 1e-3 * made.speed_mm_s)
    (stroke,) = (part for part in identify_stroke(trace, SURFACES) if part["mode"] == "stroking")
    assert stroke["fault"] is not None
    assert np.diff(stroke["impulses_s"]).max() > 0.3
    assert stroke["irregular"] is None, "each side of the fault has too few grooves for a period"


def test_a_stroke_shorter_than_a_block_has_no_segment() -> None:
    assert identify_stroke(StrokeTrace(np.arange(5) / 2000.0, np.zeros(5)), SURFACES) == []


@pytest.mark.parametrize("high_hz", [1600.0, 1900.0, 2100.0, 3950.0])
def test_a_faster_recording_shows_no_vibration_of_high_frequencies_as_roughness(high_hz: float) -> None:
    made = simulate_stroke("closely_grooved_pvc", 1, 50.0, 1.0, length_m=0.1)
    time_s = np.arange(made.time_s[0], made.time_s[-1], 1e-4)
    pressure_v, force_n, speed_mm_s = (
        np.interp(time_s, made.time_s, values) for values in (made.pressure_v, made.force_n, made.speed_mm_s)
    )
    pressure_v += 0.1 * np.sin(2.0 * np.pi * high_hz * time_s)
    (stroke,) = (
        part
        for part in identify_stroke(StrokeTrace(time_s, pressure_v, force_n, 1e-3 * speed_mm_s), SURFACES)
        if part["mode"] == "stroking"
    )
    assert stroke["surface"] == "closely_grooved_pvc"
    assert stroke["period_mm"] == pytest.approx(2.0, rel=0.01)


def test_a_faster_recording_of_a_saturated_sensor_is_as_faulty() -> None:
    made = simulate_stroke("widely_grooved_pvc", 7, 80.0, 1.0, length_m=0.07)
    pressure_v, middle = made.pressure_v.copy(), len(made.time_s) // 2
    pressure_v[middle : middle + 400] = 10.0
    time_s = np.arange(made.time_s[0], made.time_s[-1], 1e-4)
    faults = []
    for at_s in (made.time_s, time_s):
        nearest = np.searchsorted(made.time_s, at_s - 1e-9)
        trace = StrokeTrace(at_s, pressure_v[nearest], made.force_n[nearest], 1e-3 * made.speed_mm_s[nearest])
        faults.append([part["fault"] for part in identify_stroke(trace, SURFACES)])
    assert faults[0] == faults[1]
    assert any(faults[0])


@pytest.mark.parametrize(("surface", "period_mm"), [("widely_grooved_pvc", 8.0), ("closely_grooved_pvc", 2.0)])
@pytest.mark.parametrize("length_m", [0.010, 0.012, 0.020])
def test_turns_change_neither_surface_nor_period(surface: str, period_mm: float, length_m: float) -> None:
    made, direction = to_and_fro(surface, length_m, 12)
    trace = StrokeTrace(made.time_s, made.pressure_v, made.force_n, direction * 1e-3 * made.speed_mm_s)
    (stroke,) = (part for part in identify_stroke(trace, SURFACES) if part["mode"] == "stroking")
    assert stroke["surface"] == surface
    if length_m < 1.5e-3 * period_mm:
        assert stroke["period_mm"] is None, "each way crosses one groove"
    else:
        assert stroke["period_mm"] == pytest.approx(period_mm, rel=0.01)


def test_the_standard_deviation_of_a_period_is_never_0() -> None:
    made = simulate_stroke("closely_grooved_pvc", 1, 50.0, 1.0, length_m=0.16)
    trace = StrokeTrace(made.time_s, made.pressure_v, made.force_n, 1e-3 * made.speed_mm_s)
    (stroke,) = (part for part in identify_stroke(trace, SURFACES) if part["mode"] == "stroking")
    assert stroke["period_sd_mm"] == pytest.approx(0.001, abs=0.001)
    assert stroke["period_sd_mm"] > 0.0
