"""A plate that takes too much drive to hold its reading is found, and not before it has settled."""

import math

import pytest

from remote_site.safety.holding_loss import (
    LEAST_DRIVE,
    MOST_DRIVE_PER_K,
    MOST_FALL_K,
    MOST_RISE_K,
    WINDOW_S,
    HoldingLoss,
)

DT_S = 0.125
WHOLE = round(WINDOW_S / DT_S)
"""Calls of a window."""


def found(above_k: float, drive_per_k: float, calls: int, rises_k: float = 0.0, loss: HoldingLoss | None = None) -> int:
    """How often a plate is found that holds `above_k`, with a change of the reading in each window."""
    loss = loss or HoldingLoss()
    count = 0
    for call in range(calls):
        reading_k = above_k + rises_k * (call % WHOLE) / (WHOLE - 1)
        count += loss.step(DT_S, drive_per_k * above_k, reading_k)
    return count


@pytest.mark.parametrize("above_k", [5.0, 8.0, 16.0])
def test_the_drive_may_be_in_proportion_to_the_difference_from_the_air(above_k: float) -> None:
    assert found(above_k, 0.999 * MOST_DRIVE_PER_K, 10 * WHOLE) == 0
    assert found(above_k, 1.01 * MOST_DRIVE_PER_K, 2 * WHOLE - 1) == 0
    assert found(above_k, 1.01 * MOST_DRIVE_PER_K, 2 * WHOLE) == 1


def test_it_is_found_once_in_each_window_after_the_first() -> None:
    assert found(8.0, 0.02, 5 * WHOLE) == 4


@pytest.mark.parametrize(("rises_k", "judged"), [(0.0625, True), (-0.25, True), (0.125, False), (-0.375, False)])
def test_a_reading_that_changes_is_not_judged(rises_k: float, judged: bool) -> None:
    assert judged is (-MOST_FALL_K <= rises_k <= MOST_RISE_K)
    assert found(8.0, 0.05, 5 * WHOLE, rises_k) == (4 if judged else 0)


@pytest.mark.parametrize("above_k", [-4.0, 0.25, 4.0])
def test_a_small_drive_heats_no_plate_much(above_k: float) -> None:
    assert found(above_k, LEAST_DRIVE / above_k, 10 * WHOLE) == 0
    assert found(above_k, 1.01 * LEAST_DRIVE / above_k, 10 * WHOLE) == 9


@pytest.mark.parametrize(("drive", "above_k"), [(0.0, 8.0), (0.5, math.nan)])
def test_a_pause_of_drive_or_reading_begins_anew(drive: float, above_k: float) -> None:
    loss = HoldingLoss()
    for _ in range(5):
        assert found(8.0, 0.05, 2 * WHOLE - 1, loss=loss) == 0
        assert not loss.step(DT_S, drive, above_k)


def test_the_noise_of_the_drive_is_averaged() -> None:
    loss = HoldingLoss()
    drives = [0.39, -0.2] * WHOLE
    assert not any(loss.step(DT_S, drive, 8.0) for drive in drives)
    assert sum(loss.step(DT_S, drive + 0.01, 8.0) for drive in drives) == 2
