"""The study of deadbands: its channel against hand-made courses, and what a quick run finds."""

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from common.link.deadband import HEIGHT_M, REPEATS
from common.timing.timeouts import REFRESH_S
from studies.deadband import run as deadband
from studies.deadband.channel import error_m, kept, sent
from studies.deadband.courses import Course, recorded, scripted
from studies.deadband.figure import plot
from studies.deadband.loss import LIMIT_M, after_loss_rows, lossy_rows
from studies.deadband.run import run, tables
from studies.deadband.touch import force_rows
from tests.places import DATA
from tests.unit.studies.written import draw_figure, write_tables

HZ = 1000.0
RECORDINGS = pytest.mark.skipif(not (DATA / "bilateral_1dof").is_dir(), reason="no recorded motions")


def course(place_m: list[float]) -> Course:
    return Course("made", HZ, np.array([[(x_m, 0.0, 0.0)] for x_m in place_m], dtype=np.float32))


STILL = course([0.01] * 1000)
EVEN = course([0.05 * tick / HZ for tick in range(1000)])
SWAYING = course([0.02 * math.sin(0.03 * tick) for tick in range(3000)])


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=3, progress=lambda _: None)


@pytest.mark.parametrize("reckoning", ["hold", "linear"])
def test_a_still_hand_costs_a_refresh_every_12_ms(reckoning: str) -> None:
    assert sent(STILL, reckoning, 1e-4).sum() == pytest.approx(1000.0 / HZ / REFRESH_S, abs=2 + REPEATS)


def test_an_even_motion_costs_as_little_as_rest_with_dead_reckoning_and_every_step_without() -> None:
    under_way = slice(20, None)  # until two packets are 8 ms apart no speed is known
    assert sent(EVEN, "linear", 1e-4)[under_way].sum() <= sent(STILL, "linear", 1e-4)[under_way].sum() + 1
    assert sent(EVEN, "hold", 1e-4)[under_way].sum() > 500


@pytest.mark.parametrize("reckoning", ["hold", "linear"])
@pytest.mark.parametrize("step_m", [2e-5, 1e-4, 1e-3])
def test_without_loss_no_error_is_above_the_step(reckoning: str, step_m: float) -> None:
    assert error_m(SWAYING, reckoning, sent(SWAYING, reckoning, step_m)).max() <= step_m + 1e-9


def test_what_is_lost_leaves_a_larger_error_and_the_next_packet_mends_it() -> None:
    ticks = sent(SWAYING, "linear", 1e-4)
    arrives = ticks.copy()
    numbers = np.flatnonzero(ticks)
    arrives[numbers[100:104]] = False
    error = error_m(SWAYING, "linear", arrives)
    assert error[numbers[100] : numbers[104]].max() > 2e-4
    assert error[numbers[104]] < 1e-9


def test_the_first_packet_is_never_lost_and_a_loss_is_the_share_it_is_said_to_be() -> None:
    ticks = np.ones(20_000, dtype=np.bool_)
    arrives = kept(ticks, 0.2, np.random.default_rng(1))
    assert arrives[0]
    assert arrives.mean() == pytest.approx(0.8, abs=0.01)


@pytest.mark.long
def test_repeats_and_dead_reckoning_shorten_the_error_after_a_loss() -> None:
    rows = [
        row for way in ("hold", "linear") for repeats in (0, 1) for row in lossy_rows([SWAYING], way, repeats, 3, 1)
    ]
    lossless = [row for row in rows if row["loss"] == 0.0]
    assert all(row["times_above"] == 0 for row in lossless)
    most = {(row["reckoning"], row["repeats"]): row for row in rows if row["loss"] == 0.2}
    assert most["linear", 1]["above_share"] < most["hold", 1]["above_share"]
    assert most["linear", 1]["right_again_ms"] <= 1e3 * REFRESH_S
    assert most["linear", 1]["mended"] > 50
    assert most["linear", 1]["mended_p99_mm"] < 1e3 * LIMIT_M
    shown = list(after_loss_rows([SWAYING], "hold", 0, draws=1, seed=1))
    assert shown[0]["losses"] > 100
    assert shown[0]["after_ms"] == 0.0


def test_a_force_is_never_further_off_than_its_share() -> None:
    force_n = np.abs(3.0 * np.sin(0.01 * np.arange(5000)))
    for row in force_rows([force_n], HZ):
        assert row["largest_error"] <= row["weber"] + 1e-9
        assert 0.0 < row["sent_share"] < 0.5


def test_the_scripted_hand_moves_and_its_places_are_those_of_the_bus() -> None:
    hand = scripted(HZ, 3.0, seed=2)
    assert hand.place_m.shape == (3000, 5, 3)
    assert np.ptp(hand.place_m[:, 1, 2]) > 1e-3
    steps = hand.place_m[:, :, 2].astype(np.float64) / 5e-6
    assert np.abs(steps - np.round(steps)).max() < 1e-3


@pytest.mark.long
def test_chance_gaps_are_worked_out_as_they_are_drawn() -> None:
    drawn = [row for row in data()["gaps"] if row["drawn_in_an_hour"] is not None]
    assert len(drawn) > 8
    for row in drawn:
        assert row["in_an_hour"] == pytest.approx(row["drawn_in_an_hour"], rel=0.7)
    mine = next(row for row in data()["gaps"] if (row["loss"], row["refresh_ms"]) == (0.20, 1e3 * REFRESH_S))
    assert mine["in_an_hour"] < 1.0


@pytest.mark.long
@RECORDINGS
def test_recorded_motions_are_sent_with_a_seventh_of_the_packets_and_never_further_off_than_the_step() -> None:
    found = data()
    assert found["problems"] == []
    assert found["skipped"] == []
    for row in found["recordings"]:
        assert row["largest_mm"] <= 1e3 * HEIGHT_M + 1e-6
    at_recorded = [row for row in found["recordings"] if row["rate_hz"] == HZ]
    assert sum(row["sent"] for row in at_recorded) < 0.15 * sum(row["ticks"] for row in at_recorded)


@RECORDINGS
def test_every_recording_is_read_whole() -> None:
    assert {hand.name for hand in recorded()} == {path.stem for path in (DATA / "bilateral_1dof").glob("*.csv")}
    for hand in recorded():
        assert len(hand.place_m) > 4000


def test_missed_goals_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deadband, "MOST_GAPS_IN_AN_HOUR", 0.1)
    row = {"recording": "made", "rate_hz": HZ, "ticks": 100, "sent": 50, "largest_mm": 2.0}
    lossy = {
        "reckoning": "linear",
        "repeats": REPEATS,
        "loss": 0.2,
        "right_again_ms": 30.0,
        "rate_hz": HZ,
        "mended_p99_mm": 0.6,
    }
    gap = {"loss": 0.2, "refresh_ms": 1e3 * REFRESH_S, "in_an_hour": 0.6}
    problems = deadband.problems({"recordings": [row], "loss": [lossy], "gaps": [gap]})
    assert [problem.partition(":")[0] for problem in problems[:4]] == [
        "recorded motions",
        "made",
        "1000 Hz",
        "1000 Hz",
    ]
    assert "0.6 times" in problems[4]


def touch_rows(seconds: float, seed: int) -> list[dict[str, Any]]:
    """In place of a session's: a piece of work is a function of a module."""
    rows: list[dict[str, Any]] = data()["touch"]
    return rows


@pytest.mark.long
def test_without_recordings_it_says_so_and_shows_the_rest(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("TELETACTION_DATA")
    monkeypatch.setattr(deadband, "touch_rows", touch_rows)
    found = run(quick=True, seed=3, progress=lambda _: None)
    assert len(found["skipped"]) == 1
    assert {row["motion"] for row in found["sweep"]} == {"scripted"}
    draw_figure(plot, found, tmp_path)


@pytest.mark.long
def test_figure_and_tables_are_written(tmp_path: Path) -> None:
    draw_figure(plot, data(), tmp_path)
    write_tables(tables(data()), tmp_path)
