"""Stability over a delayed link: what is simulated agrees with what is known, and the local model stays passive."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.teleoperation_stability.cases import HANDS, cases
from studies.teleoperation_stability.figure import plot
from studies.teleoperation_stability.limits import (
    FREE,
    Loop,
    sampled_wall_n_m,
    simulated_n_m,
    simulated_wall_n_m,
    worked_out_n_m,
)
from studies.teleoperation_stability.matrix import (
    ARCHITECTURES,
    DIRECT,
    LOCAL,
    QUICK,
    WAVES,
    Matrix,
    matrix_rows,
    summary,
)
from studies.teleoperation_stability.measures import QUIET, START_M, PressTwice, produced_j, swing
from studies.teleoperation_stability.network import newest, way
from studies.teleoperation_stability.plant import Course, simulate
from studies.teleoperation_stability.run import tables
from studies.teleoperation_stability.waves import WaveVariables
from tests.unit.studies.written import draw_figure, write_tables

SMALL = Matrix((0.002,), (0.0, 0.1), (100.0, 500.0, 5000.0), ("steady", "loss 20 %, jitter 10 ms"), ("light",))


@cache
def small(name: str) -> list[dict[str, Any]]:
    return list(matrix_rows(SMALL, 0, 0, name, seed=0))


def of(name: str, link: str = "steady") -> list[dict[str, Any]]:
    return [row for row in small(name) if row["link"] == link]


@pytest.mark.long
@pytest.mark.parametrize("period_s", [0.001, 0.004])
def test_the_simulated_wall_of_the_device_alone_is_stable_to_colgates_bound(period_s):
    bound = 2.0 * 0.5 / period_s
    assert simulated_wall_n_m(period_s) == pytest.approx(bound, rel=0.05)
    assert sampled_wall_n_m(FREE, period_s) == pytest.approx(bound, rel=0.05)
    assert (sampled_wall_n_m(HANDS["firm"], period_s) or np.inf) > bound


@pytest.mark.long
def test_direct_force_is_stable_without_delay_and_unstable_in_its_known_region():
    rows = {(row["round_trip_ms"], row["wall_n_m"]): row for row in of(DIRECT)}
    assert rows[0.0, 100.0]["stable"]
    assert rows[100.0, 100.0]["stable"]
    for wall in (500.0, 5000.0):
        assert not rows[100.0, wall]["stable"]
        assert rows[100.0, wall]["swing_mm"] > 1.0
        assert rows[100.0, wall]["produced_mj"] > 100.0


@pytest.mark.long
def test_the_simulated_border_of_direct_force_agrees_with_the_one_worked_out():
    loops = [Loop(hand, trip_s, 0.002) for hand in (HANDS["light"], HANDS["arm"]) for trip_s in (0.02, 0.05)]
    for loop, found in zip(loops, simulated_n_m(loops), strict=True):
        assert found == pytest.approx(worked_out_n_m(loop), rel=0.15)


def test_the_border_falls_with_the_period_and_a_loop_counts_a_period_back():
    light = HANDS["light"]
    assert worked_out_n_m(Loop(light, 0.0, 0.005)) < worked_out_n_m(Loop(light, 0.0, 0.001))
    assert Loop(light, 0.0, 0.001).delay_s == pytest.approx(0.001)
    assert Loop(light, 0.020, 0.001).delay_s == pytest.approx(0.020)


@pytest.mark.long
def test_wave_variables_die_out_and_produce_nothing_at_any_constant_delay():
    rng = np.random.default_rng(1)
    trips_s = rng.uniform(0.0, 0.4, 12)
    runs = cases((list(HANDS.values())[n % 3], wall, 0.0) for n, wall in enumerate([100.0, 1000.0, 5000.0, 200.0] * 3))
    none, period_s, seconds = np.zeros(12), 0.002, 12.0
    one_way = way(round(seconds / period_s), period_s, trips_s, none, none, rng)
    press = PressTwice(runs)

    def held(t_s: float) -> tuple[np.ndarray, np.ndarray]:
        return press(min(t_s, 4.0))  # down, and never off again

    sites = WaveVariables(none + START_M, period_s)
    course = simulate(runs, sites, held, one_way, one_way, period_s=period_s, rng=rng)
    assert produced_j(course).max() < 1e-6
    early, late = (np.ptp(course.depth_m[int(a / period_s) : int(b / period_s)], axis=0) for a, b in ((3, 5), (10, 12)))
    assert np.all((late < 0.6 * early) | (late < 2e-4))


@pytest.mark.long
def test_the_local_model_never_produces_energy_swings_or_pushes_too_hard():
    rows = [row for hand in range(len(QUICK.hands)) for row in matrix_rows(QUICK, 0, hand, LOCAL, seed=0)]
    assert len(rows) == 72
    for row in rows:
        assert row["produced_mj"] <= 1.0, row
        assert row["stable"], row
        assert row["peak_n"] <= 10.0, row


@pytest.mark.long
def test_the_local_model_feels_right_at_any_delay_up_to_its_cap():
    for row in of(LOCAL) + of(LOCAL, "loss 20 %, jitter 10 ms"):
        assert row["felt_n_m"] == pytest.approx(min(500.0, row["wall_n_m"]), rel=0.05)  # 2 b / T = 500 N/m


@pytest.mark.long
def test_waves_feel_soft_when_late():
    felt = {(row["round_trip_ms"], row["wall_n_m"]): row["felt_n_m"] for row in of(WAVES)}
    assert felt[100.0, 5000.0] < 0.5 * felt[0.0, 5000.0]


def test_newest_packets():
    delay_s = np.array([[0.0], [0.003], [0.001], [0.0], [0.0]])
    lost = np.array([[False], [False], [False], [True], [False]])
    assert newest(delay_s, lost, 0.001)[:, 0].tolist() == [0, 0, 0, 2, 4]
    assert newest(delay_s + 1.0, lost, 0.001)[:, 0].tolist() == [-1] * 5


@given(st.integers(0, 1000), st.floats(0.0, 0.01), st.floats(0.0, 0.9))
def test_a_link_never_goes_back_and_is_never_early(seed, round_trip_s, loss):
    ticks = way(50, 0.001, np.array([round_trip_s]), np.array([0.002]), np.array([loss]), np.random.default_rng(seed))
    assert np.all(np.diff(ticks[:, 0]) >= 0)
    assert np.all(ticks[:, 0] * 0.001 <= np.arange(50) * 0.001 - 0.5 * round_trip_s + 1e-6 + (ticks[:, 0] < 0))


def made(depth_m: np.ndarray) -> Course:
    """A course of which only the depth is known, a period of 1 ms."""
    return Course(0.001, depth_m[:, None], *np.zeros((5, len(depth_m), 1)))


@pytest.mark.parametrize(("hz", "dies_per_s", "swings"), [(8.0, 0.0, True), (8.0, -1.0, True), (8.0, 1.0, False)])
def test_a_lasting_oscillation_is_distinguished_from_a_decaying_one(hz, dies_per_s, swings):
    t_s = 0.001 * np.arange(6000)
    depth = 1e-3 * np.exp(-dies_per_s * (t_s - 4.0)) * np.sin(2.0 * np.pi * hz * t_s) + 0.001 * t_s
    amplitude_m, frequency_hz = swing(made(depth))
    assert (amplitude_m[0] > 0.0) == swings
    assert frequency_hz[0] == (pytest.approx(hz, rel=0.1) if swings else 0.0)


class Still:
    """Nobody moves, and the remote finger rests in the wall."""

    packet_rows = 1

    def operator(self, depth_m, packet):
        return 0.0 * depth_m, packet

    def remote(self, at, packet):
        return 0.0 * at.depth_m + 0.003, 0.0 * at.depth_m, packet


@pytest.mark.long
def test_a_wall_breathes_once_and_stands():
    runs = cases([(HANDS["light"], 500.0, 0.002)])
    none = np.zeros(1)
    one_way = way(5000, 0.001, none, none, none, np.random.default_rng(0))
    course = simulate(
        runs, Still(), lambda _: (none, none), one_way, one_way, period_s=0.001, rng=np.random.default_rng(0)
    )
    breathing, standing = course.remote_m[500:3333, 0], course.remote_m[round(1000 * QUIET[0]) : 5000, 0]
    assert np.ptp(breathing) > 0.0005
    assert np.ptp(standing) < 1e-5
    assert course.wall_j[-1, 0] == pytest.approx(course.wall_j[3400, 0], abs=1e-7)


@pytest.mark.long
def test_tables_and_figure_are_written(tmp_path: Path):
    rows = [row for name in ARCHITECTURES for row in small(name)]
    border = {"hand": "light", "round_trip_ms": 100.0, "worked_out_n_m": 180.0, "simulated_n_m": None}
    data = {
        "summary": list(summary(rows)),
        "borders": [border, border | {"hand": "firm", "worked_out_n_m": None}],
        "walls": [{"period_ms": 1.0, "bound_n_m": 1000.0}],
        "recorded": [],
        "matrix": rows,
    }
    write_tables(tables(data), tmp_path)
    draw_figure(plot, data, tmp_path, 20_000)
