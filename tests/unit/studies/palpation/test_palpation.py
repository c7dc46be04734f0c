"""The study of recorded presses on made-up ones whose answers are known, and on the recordings where they are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from remote_site.traces.press_files import Contact, Press
from studies.palpation import run as study
from studies.palpation.presses import LAW, LINE, SLOPE, answered, intraclass_correlation, predicted, repeated
from studies.palpation.recordings import Stream, read_stream
from studies.palpation.shown import DRAWN, LIVE, RECORDED, REGRESSION, STEPPED, neighbour_cv, pair_cv, shown, streamed
from studies.palpation.shown import LAW as TANGENT
from studies.running import Unavailable
from tests.places import DATA
from tests.presses import spring_presses
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
    row = answered("made", made())
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


@pytest.mark.long
def test_the_bars_of_the_recordings(tmp_path: Path):
    folder = DATA / "palpation"
    if not folder.is_dir():
        pytest.skip(f"no recordings in {folder}; TELETACTION_DATA names their folder")
    data = study.run(quick=False, seed=0, progress=lambda _: None)
    missed = {row["bar"] for row in data["bars"] if row["reached"] is None and LIVE not in row["bar"]}
    assert missed <= {f"windows, CV: {RECORDED}"}
    write_tables(study.tables(data), tmp_path)
    draw_figure(study.plot, data, tmp_path)
