"""The study of surfaces holds on presses of another seed, and its physics is that of the simulated finger."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_sensors.physics.fingertip import Fingertip
from studies.surface_identification.figure import (
    draw_breath,
    draw_errors,
    draw_jitter,
    draw_known,
    draw_nodule,
    draw_wrong,
)
from studies.surface_identification.pressed_surface import TICK_S, minimum_jerk, simulate
from studies.surface_identification.run import run, tables
from tests.unit.studies.written import draw_panels, write_tables


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=83, progress=lambda _: None)


@pytest.mark.long
def test_one_press_identifies_the_stiffness() -> None:
    assert all(row["error_most"] <= 0.15 for row in data()["presses"])
    assert sum(row["known"] for row in data()["presses"]) >= 0.97 * sum(row["count"] for row in data()["presses"])


@pytest.mark.long
def test_a_known_stiffness_is_right_and_before_that_it_is_too_small() -> None:
    for row in data()["known"]:
        assert row["share_right_when_known"] >= 0.999
        assert row["harder_n"] <= 0.05
        assert row["seconds_most"] < 1.0
        assert row["median_force_n"] < 2.0


@pytest.mark.long
def test_the_identified_surface_is_quiet_and_not_late() -> None:
    assert all(row["told_mm"] < 0.03 and row["told_mm"] < 0.6 * row["raw_mm"] for row in data()["jitter"])
    assert all(row["lag_ms"] <= 30.0 for row in data()["moving"])
    soft = [row for row in data()["moving"] if row["stiffness_n_m"] < 3000.0]
    assert all(row["force_off_rms_n"] < 0.15 for row in soft)
    assert all(abs(row["stiffness_error"]) < 0.15 for row in soft)


@pytest.mark.long
def test_more_presses_on_a_breathing_surface_make_more_known() -> None:
    for row in data()["again"]:
        if not row["breathes"]:
            assert row["known"] > 0.99
            assert row["known_and_wrong"] == 0.0
    soft = [row for row in data()["again_by_time"] if row["breathes"] and row["stiffness_n_m"] == 150.0]
    assert np.mean([row["known"] for row in soft[-3:]]) > 0.8


@pytest.mark.long
def test_a_nodule_and_a_slope_are_identified() -> None:
    for row in data()["nodule"]:
        assert (row["onto_ms"] if row["onto_ms"] is not None else np.inf) <= 50.0
        assert (row["off_ms"] if row["off_ms"] is not None else np.inf) <= 50.0
    assert all(row["mean"] == pytest.approx(0.1, abs=0.01) for row in data()["slope"])


@pytest.mark.long
def test_a_tick_costs_no_more_than_its_share() -> None:
    for row in data()["cost"]:
        assert row["times_a_bare_call"] < 300.0


def test_the_physics_is_that_of_the_simulated_fingertip() -> None:
    def setpoint_m(t_s: float) -> np.ndarray:
        return 2e-3 - 5e-3 * minimum_jerk(np.array([t_s / 0.3]))

    touches = simulate(0.6, setpoint_m, lambda _: np.array([800.0]))
    tip = Fingertip(2e-3)
    for tick in range(len(touches.force_n) - 1):
        tip.step(TICK_S, float(setpoint_m(tick * TICK_S)[0]), 0.0, 800.0)
    assert tip.z_m == pytest.approx(touches.z_m[-1, 0], abs=2e-6)
    assert tip.force_n == pytest.approx(touches.force_n[-1, 0], abs=0.01)


@pytest.mark.long
def test_tables_and_panels_are_drawn(tmp_path: Path) -> None:
    write_tables(tables(data()), tmp_path)
    panels = (draw_errors, draw_jitter, draw_breath, draw_nodule, draw_known, draw_wrong)
    draw_panels(panels, data(), tmp_path)
