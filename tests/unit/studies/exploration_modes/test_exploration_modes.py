"""Modes at three times the nominal noise, in scenes that the machine was not looked at with."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_sensors.traces.simulated_exploration import sense
from studies.exploration_modes.figure import draw_latencies, draw_tap_speeds, draw_time_right
from studies.exploration_modes.judge import JUDGED, MACHINE, PLAIN, latencies, listen, longest_run, wrong_switches
from studies.exploration_modes.run import METHODS, run, tables
from studies.exploration_modes.scenes import SCENES, scene
from tests.unit.studies.written import draw_panels, write_tables

SEEDS = range(90_000, 90_008)


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=7, progress=lambda _: None)


def level(method: str, noise: float = JUDGED) -> dict[str, Any]:
    return next(row for row in data()["levels"] if (row["method"], row["noise"]) == (method, noise))


@pytest.mark.long
@pytest.mark.parametrize("kind", SCENES)
def test_each_kind_of_scene_gets_the_right_modes(kind: str) -> None:
    right = ticks = 0
    for seed in SEEDS:
        explored = scene(kind, seed)
        reported = listen(METHODS[MACHINE], explored, sense(explored, JUDGED, np.random.default_rng(seed)))
        right += int(np.count_nonzero(reported.mode == explored.mode))
        ticks += len(explored.mode)
        assert longest_run(wrong_switches(explored.mode, reported.mode)) <= 1
        assert len(reported.taps) == len(explored.landings)
    # Shaking after a stroke is distinguished from a turn a quarter of a second later.
    assert right / ticks >= (0.96 if kind == "shaking arm" else 0.98)


@pytest.mark.long
def test_time_right_switches_and_taps_hold_at_three_times_the_noise() -> None:
    machine, plain = level(MACHINE), level(PLAIN)
    assert machine["right"] >= 0.98 > plain["right"]
    assert machine["longest_wrong_run"] <= 1
    assert machine["wrong_switches"] <= 0.01 * machine["switches"]
    assert machine["contacts_within_5_ms"] >= 0.95
    assert machine["invented_taps"] == 0
    assert level(MACHINE, 10.0)["right"] < 0.98, "it says where it fails"


@pytest.mark.long
def test_the_speed_of_a_tap_is_that_before_the_impact() -> None:
    for noise in (1.0, JUDGED):
        for method, most in ((MACHINE, 0.2), (PLAIN, 0.6)):
            rows = [row for row in data()["taps"] if (row["method"], row["noise"]) == (method, noise)]
            assert np.sqrt(np.average([r["rms"] ** 2 for r in rows], weights=[r["count"] for r in rows])) < most


def test_the_judge_knows_wrong_from_late() -> None:
    explored = scene("strokes", 90_100)
    reported = listen(METHODS[MACHINE], explored, sense(explored, 1.0, np.random.default_rng(0)))
    assert wrong_switches(explored.mode, explored.mode) == [False] * int(np.count_nonzero(np.diff(explored.mode)))
    late = np.roll(explored.mode, 10)
    late[:10] = explored.mode[0]
    assert not any(wrong_switches(explored.mode, late))
    assert any(wrong_switches(explored.mode, (explored.mode + 1) % 4))
    assert longest_run([True, False, True, True, False]) == 2
    assert all(late_s is not None and late_s < 0.2 for _, late_s, _ in latencies(explored.mode, reported))


@pytest.mark.long
def test_tables_and_panels_are_drawn(tmp_path: Path) -> None:
    write_tables(tables(data()), tmp_path)
    draw_panels((draw_time_right, draw_latencies, draw_tap_speeds), data(), tmp_path)
