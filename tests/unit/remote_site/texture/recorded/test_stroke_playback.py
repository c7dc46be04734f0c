"""Recorded strokes at the sensor's rate."""

import numpy as np

from remote_site.texture.recorded.identify_texture import identify_stroke
from remote_site.traces.trace_files import StrokeTrace
from sim_sensors.traces.simulated_stroke import simulate_stroke
from tests.unit.remote_site.shipped_tables import SURFACES


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
