"""Real strokes: fabrics at a pressure never learned from, against the classic methods on the same splits."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from remote_site.texture.groove_period import Period
from studies.recorded_strokes.figure import draw_boards, draw_coverage, draw_fabrics, draw_speeds
from studies.recorded_strokes.periods import counted, made_periods, pooled
from studies.recorded_strokes.run import FABRIC, Stroke, classic, judged, read_strokes, run, shipped, splits, varied
from studies.running import Unavailable
from studies.texture.baselines import band_powers, classifiers
from tests.places import DATA
from tests.slow_strokes import folder_of


@pytest.mark.long
def test_fabrics_at_another_pressure_are_named_better_than_by_the_classic_methods():
    try:
        strokes = read_strokes(DATA / "fabric_strokes", FABRIC)
    except Unavailable as absent:
        pytest.skip(f"{absent}; TELETACTION_DATA names their folder")
    settings = splits(strokes, 0)["setting left out"]
    ours = [row["right"] for row in judged(strokes, settings, shipped)[0]]
    for classifier in classifiers():
        method = classic(lambda trace: band_powers(trace.signals, trace.rate_hz), classifier, 0)
        theirs = [row["right"] for row in judged(strokes, settings, method)[0]]
        assert all(own >= other for own, other in zip(ours, theirs, strict=True)), (classifier, ours, theirs)
        assert sum(ours) > sum(theirs) + 0.05 * len(strokes), (classifier, ours, theirs)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The study over made-up recordings with the names of the real ones."""
    out = tmp_path_factory.mktemp("recordings")
    (out / "groove_boards").mkdir()
    (out / "fabric_strokes").mkdir()
    header = ",".join(("time_s", *(f"taxel{k + 1}" for k in range(16))))
    chance = np.random.default_rng(0)
    t = np.arange(0.0, 15.0, 0.028)
    shifts = chance.uniform(0.0, 6.0, 16)
    waves = 100.0 + 5.0 * np.sin(5.0 * np.pi * t[:, None] + shifts) + chance.normal(size=(len(t), 16))
    board = out / "groove_boards" / "board2mm_force120_speed10mmps.csv"
    np.savetxt(board, np.column_stack([t, waves]), fmt="%.3f", delimiter=",", header=header, comments="")
    for load in (120, 180):
        for number, one in enumerate(folder_of((load,), seed=load)):
            name = f"{one.surface}_force{load}_speed{1e3 * one.speed_m_s:.0f}mmps_{number % 3}.csv"
            rows = np.column_stack([one.trace.time_s, one.trace.signals])
            path = out / "fabric_strokes" / name
            np.savetxt(path, rows, fmt="%.3f", delimiter=",", header=header, comments="")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TELETACTION_DATA", str(out))
        return run(quick=True, seed=0, progress=lambda _: None)


@pytest.mark.long
def test_boards_and_fabrics_are_counted(made):
    assert [round(row["period_mm"], 1) for row in made["boards"]] == [4.0, 4.0]
    assert made["taxels"]["the_board"] == 16
    shares = [r["share"] for r in made["accuracy"] if r["method"] == "shipped" and r["split"] == "setting left out"]
    assert len(shares) == 2
    assert min(shares) > 0.8
    assert {row["split"] for row in made["accuracy"]} == {
        "setting left out",
        "at random",
        "one setting learned",
        "other half",
    }
    assert all(row["low"] <= row["share"] <= row["high"] for row in made["accuracy"])


@pytest.mark.long
def test_panels_are_drawn(made):
    left, right, speeds, coverage = Figure().subplots(2, 2).flat
    draw_boards(left, made)
    draw_fabrics(right, made)
    draw_speeds(speeds, made)
    draw_coverage(coverage, made)
    assert len(right.get_lines()) >= 3 * 5
    assert len(speeds.get_lines()) == 3 * 2
    assert coverage.get_lines()
    assert left.get_ylabel()


def test_periods_are_counted():
    answers = [(4.0, Period(0.00401, 0.00002, 0.0)), (4.0, Period(0.0023, 0.00002, 0.0)), (4.0, None)]
    row = counted(answers)
    assert (row["none"], row["wrong"], row["within_1_percent"], row["inside_95"], row["answers"]) == (1, 1, 1, 1, 2)
    assert counted([(4.0, None)])["inside_95_share"] is None


@pytest.mark.long
def test_stated_deviations_of_made_up_strokes_are_true_and_few_periods_are_of_another_line():
    """Over 2 to 10 mm/s, half of the strokes with a finger that sticks and slips; other draws than the study's."""
    rows = [row for speed_mm_s in (2.0, 5.0, 10.0) for row in made_periods(speed_mm_s, 160, 7)]
    (all_taxels,) = (row for row in pooled(rows) if row["signals"] == "all taxels" and row["motion"] == "both")
    assert all_taxels["strokes"] == 480
    assert all_taxels["answers"] > 400
    assert all_taxels["inside_95_share"] == pytest.approx(0.95, abs=0.05)
    assert all_taxels["wrong"] < 0.05 * all_taxels["strokes"]


def test_one_taxel_of_all_is_a_method_too():
    strokes = [Stroke(one.trace, one.speed_m_s, 0, one.surface) for one in folder_of((120,))]
    assert len(varied(taxel=9)(strokes, strokes)) == len(strokes)
