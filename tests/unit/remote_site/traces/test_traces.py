"""Traces of arrays are checked as files are: lengths, finite numbers, ascending times, units."""

import numpy as np
import pytest

from remote_site.traces.trace_files import StrokeTrace, ThermalTrace

TIME_S = np.arange(5) * 0.01
SENSOR_C = np.full(5, 33.0)
FORCE_N = np.zeros(5)


def test_lists_become_arrays() -> None:
    trace = ThermalTrace([0, 1e-2], [33, 33], [0, 1])  # type: ignore[arg-type]  # as a user may write them
    assert trace.sensor_c.dtype == np.float64
    assert trace.ambient_c is None


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"sensor_c": SENSOR_C[:4]}, r"index: column sensor_c: shape \(4,\) beside 5 times"),
        ({"sensor_c": SENSOR_C[:, np.newaxis]}, r"column sensor_c: shape \(5, 1\)"),
        ({"force_n": [0.0, 0.0, np.nan, 0.0, 0.0]}, "column force_n: sample 2 is not a finite number"),
        ({"time_s": [0.0, 0.1, 0.1, 0.2, 0.3]}, "column time_s: does not ascend at sample 2"),
        ({"sensor_c": SENSOR_C + 273.15}, "column sensor_c: .* kelvin"),
        ({"ambient_c": np.full(5, 73.0)}, "column ambient_c: .* Fahrenheit"),
        ({"time_s": TIME_S * 1e3}, "column time_s: .* milliseconds"),
        ({"force_n": np.full(5, 120.0)}, "column force_n: .* grams"),
    ],
)
def test_a_touch_that_cannot_be_right_is_refused(wrong: dict[str, object], message: str) -> None:
    columns = {"time_s": TIME_S, "sensor_c": SENSOR_C, "force_n": FORCE_N, "name": "index"}
    with pytest.raises(ValueError, match=message):
        ThermalTrace(**columns | wrong)  # type: ignore[arg-type]


def test_one_sample_is_too_few() -> None:
    with pytest.raises(ValueError, match="fewer than two samples"):
        ThermalTrace(TIME_S[:1], SENSOR_C[:1], FORCE_N[:1])


def test_a_stroke_has_one_or_more_signals() -> None:
    assert StrokeTrace(TIME_S, SENSOR_C).signals.shape == (5, 1)
    assert StrokeTrace(TIME_S, np.zeros((5, 2)), signal_names=("a", "b")).signals.shape == (5, 2)
    with pytest.raises(ValueError, match="2 signals and 1 names"):
        StrokeTrace(TIME_S, np.zeros((5, 2)))
    with pytest.raises(ValueError, match=r"column speed_m_s: .* mm/s; divide by 1000"):
        StrokeTrace(TIME_S, SENSOR_C, speed_m_s=np.full(5, 50.0))
