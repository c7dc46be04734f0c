"""Bins: every value is in one, the peaks survive, and time that jumps leaves nothing of another time behind."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from operator_site.console.state.signals import BINS, LATE_S, SIGNALS, SPAN_S, Signals

PLATE = SIGNALS.index("plate_c")


def filled(times_s: list[float]) -> Signals:
    """Each finger's force is its number plus the time; motor and plate beside it."""
    signals = Signals()
    for t_s in times_s:
        signals.take(t_s, "force_n", [[t_s + finger for finger in range(5)]])
        signals.take(t_s, "motor_hz", [[1.0] * 5, [math.nan] * 4 + [30.0]])
    return signals


def test_a_peak_of_one_sample_is_in_its_bin_on_its_finger() -> None:
    signals = Signals()
    for n in range(1000):
        signals.take(0.002 * n, "contact_n", [[0.0, 0.0, 9.0 if n == 500 else 1.0, 0.0, 0.0]])
    newest = signals.newest_bin(2.0)
    bins = signals.bins(newest, newest + 1)
    column = 2 * len(SIGNALS) + SIGNALS.index("contact_n")
    peak = math.floor(1.0 / SPAN_S)
    assert bins[peak, column].tolist() == [1.0, 9.0]
    assert (np.delete(bins[:, column], peak, axis=0) == 1.0).all()


def test_what_never_came_is_nan() -> None:
    signals = filled([0.002 * n for n in range(200)])
    bins = signals.bins(signals.newest_bin(0.4), 5).reshape(5, 5, len(SIGNALS), 2)
    assert np.isnan(bins[:, :4, PLATE]).all()
    assert (bins[:, 4, PLATE] == 30.0).all()
    assert np.isnan(bins[:, :, SIGNALS.index("skin_c")]).all()


def test_a_bin_is_complete_when_something_later_came() -> None:
    signals = filled([0.002 * n for n in range(100)])  # up to 0.198 s
    assert signals.newest_bin(0.2 + 0.5 * SPAN_S) == math.floor(0.198 / SPAN_S) - 1
    late_s = 0.198 + LATE_S + 0.01
    assert signals.newest_bin(late_s) == math.floor(late_s / SPAN_S) - 1
    silent = signals.bins(signals.newest_bin(late_s), 3)
    assert np.isnan(silent[-1]).all(), "a silent feed leaves a gap, not its last value"


def test_more_than_is_kept_is_a_gap() -> None:
    signals = filled([100.0 + 0.01 * n for n in range(3000)])
    newest = signals.newest_bin(130.0)
    bins = signals.bins(newest, BINS)
    assert np.isfinite(bins[1:, 0]).all()
    assert signals.bins(newest - BINS, 10).shape == (10, 25, 2)
    assert np.isnan(signals.bins(newest - BINS - 5, 1)).all()


@given(st.lists(st.floats(0.0, 40.0), min_size=1, max_size=60))
def test_whatever_the_clock_does_bins_hold_only_values_of_their_time(times_s: list[float]) -> None:
    signals = filled(times_s)
    newest = signals.newest_bin(times_s[-1] + 1.0)
    bins = signals.bins(newest, BINS)
    low, high = bins[:, 0, 0], bins[:, 0, 1]
    for number, (least, most) in enumerate(zip(low, high, strict=True), newest - BINS + 1):
        if np.isfinite(least):
            assert math.floor(least / SPAN_S + 1e-4) >= number
            assert math.floor(most / SPAN_S - 1e-4) <= number
    last = math.floor(times_s[-1] / SPAN_S)
    if last > newest - BINS:
        assert high[last - (newest - BINS + 1)] >= np.float32(times_s[-1]) - 1e-5
