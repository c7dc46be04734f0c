"""The study of recorded presses on made-up ones whose answers are known, and on the recordings where they are."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from remote_site.traces.press_files import Contact, Press
from studies.palpation import run as study
from studies.palpation.figure import draw_bars, plot
from studies.palpation.presses import LAW, LINE, SLOPE, answered, intraclass_correlation, predicted, repeated
from studies.palpation.recordings import Stream, read_stream
from studies.palpation.shown import DRAWN, LIVE, RECORDED, REGRESSION, STEPPED, neighbour_cv, pair_cv, shown, streamed
from studies.palpation.shown import LAW as TANGENT
from studies.pieces import Piece
from studies.running import Unavailable
from tests.places import DATA
from tests.presses import spring_presses, write_presses
from tests.unit.studies.written import draw_figure, write_tables


def made(count: int = 20, **how: float) -> list[Press]:
    presses = spring_presses(count, deepest_mm=2.97, **how)  # type: ignore[arg-type]
    return [replace(press, contact=Contact(status="ok")) for press in presses]


def stream(noise_n: float = 0.01) -> Stream:
    """A probe that presses a spring of 500 N/m with a sine of 2 Hz and moves on."""
    random = np.random.default_rng(1)
    time_s = np.arange(0.0, 20.0, 1.0 / 66.0)
    depth_mm = 2.2 + 1.8 * np.sin(4.0 * np.pi * time_s)
    place_mm = np.column_stack([3.0 * time_s, np.zeros_like(time_s), -depth_mm])
    return Stream(time_s, place_mm, 0.5 * depth_mm + noise_n * random.standard_normal(len(time_s)))


def test_each_press_of_a_stated_contact_is_answered():
    (row,) = answered("made", made())
    assert (row["presses"], row["failed"]) == (20, 0)
    assert row["known"] + row["uncertain"] == 20


def test_a_stiffening_press_is_predicted_better_than_by_a_line():
    rows = predicted("made", "liver", made(exponent=2.5))
    error = {method: np.median([row["errors"] for row in rows if row["method"] == method]) for method in (LAW, LINE)}
    assert error[LAW] < 0.05
    assert error[LINE] > 0.2


def test_repeats_are_compared_by_press():
    one, other = made(seed=1, noise_n=0.0), made(seed=1, noise_n=0.0)
    rows = {row["method"]: row for row in repeated(one, other[::-1][:15])}
    assert rows[LAW]["pairs"] == 15
    assert rows[LAW]["icc"] > 0.95
    assert rows[LAW]["cv"] < 0.03
    assert rows[LAW]["outside_2_sd"] <= rows[LAW]["outside_2_repeat_sd"]
    assert rows[SLOPE]["outside_2_sd"] is None


def test_intraclass_correlation():
    random = np.random.default_rng(2)
    place = random.normal(0.0, 2.0, 20_000)
    one, other = (place + random.normal(0.0, 1.0, len(place)) for _ in range(2))
    assert intraclass_correlation(one, other) == pytest.approx(0.8, abs=0.02)


def test_a_tangent_is_no_harder_than_a_stiffening_press():
    rows = {row["way"]: row for row in shown("made", made(exponent=2.5, noise_n=0.003))}
    assert rows[TANGENT]["too_hard"] == 0.0
    assert set(rows) == {TANGENT, STEPPED, DRAWN}


def test_a_steady_stream_repeats():
    rows = {row["method"]: row for row in streamed("made", stream())}
    assert set(rows) == {LIVE, RECORDED, REGRESSION}
    assert rows[RECORDED]["windows"] == pytest.approx(40, abs=1)
    assert rows[RECORDED]["known"] > 0.9
    assert rows[REGRESSION]["cv"] < 0.01
    assert rows[RECORDED]["cv_of_halves"] < 0.02
    assert rows[LIVE]["cv_of_halves"] is None


def test_a_trend_is_no_variation():
    assert neighbour_cv(np.exp(np.linspace(5.0, 7.0, 50))) < 1e-9
    random = np.random.default_rng(3)
    assert neighbour_cv(500.0 * np.exp(0.04 * random.standard_normal(20_000))) == pytest.approx(0.04, rel=0.05)


def test_a_change_between_windows_is_no_variation_of_their_halves():
    random = np.random.default_rng(3)
    place = 500.0 * np.exp(random.standard_normal(20_000))
    one, other = (place * np.exp(0.04 * random.standard_normal(len(place))) for _ in range(2))
    assert pair_cv(one, other) == pytest.approx(0.04, rel=0.05)


def test_without_a_stream_the_error_names_it(tmp_path: Path):
    with pytest.raises(Unavailable, match="ContPalpTrial5"):
        read_stream(tmp_path, "ContPalpTrial5")


def recordings(folder: Path) -> Path:
    """Write recordings with the names that a quick run looks for."""
    for name in ("kidney_bar_t1", "kidney_bar_t2", "meat_a_overlap", "liver2_r1", "liver2_r2", "truth", "continuous"):
        (folder / name).mkdir()
        write_presses(folder / name, spring_presses(3))
        (folder / name / "contacts.csv").write_text("press,status\n0,ok\n1,ok\n2,ok\n")
    (folder / "continuous" / "ContPalpTrial5.csv").write_text("time_s,x_mm,y_mm,z_mm,fz_n\n0,0,0,0,0\n")
    (folder / "truth" / "kidney_bar.csv").write_text("x_mm,y_mm,lump\n0,0,1\n1,0,0\n")
    return folder


def test_pieces_hold_the_recordings_since_other_machines_lack_the_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Piece] = []

    def work(pieces: Sequence[Piece], progress: object) -> list[Any]:
        asked.extend(pieces)
        raise InterruptedError

    monkeypatch.setenv("TELETACTION_DATA", str(tmp_path))
    (tmp_path / "palpation").mkdir()
    folder = recordings(tmp_path / "palpation")
    with pytest.raises(InterruptedError):
        study.run(quick=True, seed=0, progress=lambda _: None, work=work)  # type: ignore[arg-type]
    assert {function.__name__ for function, _ in asked} >= {"judged_maps", "chosen_one_by_one"}
    assert not [each for _, arguments in asked for each in arguments if isinstance(each, Path)]
    (folder / "truth" / "kidney_bar.csv").write_text("x_mm,y_mm\n0,0\n")
    with pytest.raises(ValueError, match=r"kidney_bar\.csv: line 1: column lump is missing"):
        study.run(quick=True, seed=0, progress=lambda _: None, work=work)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("0.0,0,0,0,0\n0.1,0,0\n", "line 3: 3 values under 5 columns"),
        ("0.0,0,0,0,x\n", "line 2: column fz_n: not a finite number"),
        ("", "no line of data"),
    ],
)
def test_a_stream_that_cannot_be_read_is_named_with_its_line(tmp_path: Path, rows: str, words: str):
    (tmp_path / "continuous").mkdir()
    path = tmp_path / "continuous" / "some.csv"
    path.write_text("time_s,x_mm,y_mm,z_mm,fz_n\n" + rows)
    with pytest.raises(ValueError, match=f"{re.escape(str(path))}: .*{words}"):
        read_stream(tmp_path, "some")


@pytest.mark.long
def test_the_bars_of_the_recordings(tmp_path: Path):
    folder = DATA / "palpation"
    if not folder.is_dir():
        pytest.skip(f"no recordings in {folder}; TELETACTION_DATA names their folder")
    data = study.run(quick=False, seed=0, progress=lambda _: None)
    missed = {row["bar"] for row in data["bars"] if row["reached"] is None}
    assert missed <= {f"windows, CV: {LIVE}", f"windows, CV: {RECORDED}"}
    write_tables(study.tables(data), tmp_path)
    draw_figure(plot, data, tmp_path)


@pytest.mark.parametrize(("value", "shown"), [(0.0, False), (0.01, True)])
def test_any_value_above_a_limit_of_zero_has_a_bar(value: float, shown: bool):
    row = {"bar": "presses without an answer", "of": "all", "value": value, "honest_from": 0.0, "honest_to": 0.0}
    axes = Figure().add_subplot()
    draw_bars(axes, {"bars": [row | {"reached": None}]})
    (bar,) = axes.patches
    assert bool(bar.get_width() > 1.0) is shown
