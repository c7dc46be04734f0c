"""The study of recorded touches: its linear classifier exactly, its counting, and one set of the real recordings.

The recordings are no part of the project. They are looked for where TELETACTION_DATA says, else beside the checkout.
"""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from remote_site.traces.trace_files import ThermalTrace
from studies.recorded_touches.figure import plot
from studies.recorded_touches.run import (
    BOTH,
    HEATED,
    HELPED,
    METAL,
    PRIORS,
    TIMES_S,
    WOOD,
    accuracy,
    linear_features,
    linear_score,
    run,
)
from studies.thermal_identification.operating_curve import RULES
from tests.places import DATA
from tests.unit.studies.written import draw_figure

Array = NDArray[np.float64]


def test_the_linear_classifier_finds_the_best_line_between_two_normals() -> None:
    random = np.random.default_rng(1)
    covariance = np.array([[1.0, 0.8], [0.8, 1.0]])
    metal = np.arange(4000) < 2000
    features = random.multivariate_normal([0.0, 0.0], covariance, 4000) + np.where(metal[:, None], [1.0, 0.0], 0.0)
    scores = linear_score(features, metal, np.array([[1.0, 0.0], [0.0, 0.0], [0.5, 0.0]]))
    half_distance = 0.5 * np.array([1.0, 0.0]) @ np.linalg.solve(covariance, [1.0, 0.0])
    assert scores == pytest.approx([half_distance, -half_distance, 0.0], abs=0.15)


def test_no_reading_after_its_time_is_a_feature() -> None:
    time_s = np.asarray(np.arange(800) * 0.01)
    readings = [np.asarray(30.0 - 0.1 * time_s), np.asarray(22.0 - 0.2 * time_s)]
    later = [np.where(time_s > 2.5 + 1e-9, 45.0, reading) for reading in readings]
    force_n = np.where(time_s >= 1.0 - 1e-9, 2.0, 0.0)  # contact at 1.0 s
    for sensors in (HEATED, BOTH):
        plain, changed = (
            linear_features(ThermalTrace(time_s, np.asarray(a), force_n, None, np.asarray(b)), 1.5, sensors)
            for a, b in (readings, later)
        )
        assert np.array_equal(plain, changed)


def test_a_recording_that_ends_before_its_time_has_no_features() -> None:
    time_s = np.asarray(np.arange(400) * 0.01)
    trace = ThermalTrace(time_s, 30.0 - time_s, np.where(time_s >= 1.0 - 1e-9, 2.0, 0.0), name="short")
    assert len(linear_features(trace, 2.5, HEATED)) == 21
    with pytest.raises(ValueError, match=r"short: fewer than 4 s of contact"):
        linear_features(trace, 4.0, HEATED)


def test_right_and_wrong_are_counted_by_class() -> None:
    cell = {"method": "linear", "sensors": HEATED, "prior": "even", "t_s": 1.5}
    said = [("metal", METAL, METAL), ("wood", WOOD, WOOD), ("wood", WOOD, METAL), ("cooled_wood", WOOD, METAL)]
    (row,) = accuracy([{**cell, "class": name, "material": true, "said": word} for name, true, word in said])
    assert (row["touches"], row["right"], row["share"]) == (4, 2, 0.5)
    assert row["balanced"] == pytest.approx((1.0 + 1.0 / 3.0) / 2.0)
    assert (row["metal_wrong"], row["wood_wrong"], row["cooled_wood_wrong"]) == (0, 1, 1)


@pytest.mark.long
def test_the_figure_shows_every_way_to_sense(tmp_path: Path) -> None:
    cells = [
        {"method": method, "sensors": sensors, "prior": "even", "t_s": t_s, "touches": 9, "share": 0.5}
        for method in ("linear", "estimator")
        for sensors in (HEATED, HELPED, BOTH)
        for t_s in TIMES_S
    ]
    names = [
        {"method": sensors, "caution": rule.caution, "named_3_s": 0.2, "named_6_s": share, "wrong": 0.01}
        | {"strangers_named": None}
        for sensors, share in ((HEATED, 0.5), (HELPED, 0.4), (BOTH, 0.8))
        for rule in RULES
    ]
    draw_figure(plot, {"accuracy": cells, "names": names}, tmp_path)


@pytest.mark.study
@pytest.mark.timeout(600)
def test_both_methods_answer_every_touch_of_a_set_that_was_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A touch of each class from three sets: every answer is given and counted; too few to say how good they are."""
    found = []
    for group in ("01", "02", "03"):
        for name in ("metal", "wood", "cooled_wood"):
            found += sorted((DATA / "thermal_contact").glob(f"set{group}_{name}_*.csv"))[:1]
    if len(found) < 9:
        pytest.skip(f"no recordings in {DATA}; TELETACTION_DATA names the folder that holds thermal_contact")
    (tmp_path / "thermal_contact").mkdir()
    for path in found:
        (tmp_path / "thermal_contact" / path.name).write_bytes(path.read_bytes())
    monkeypatch.setenv("TELETACTION_DATA", str(tmp_path))
    shares: list[float] = []
    data = run(quick=True, seed=0, progress=shares.append)
    assert data["sets"] == [1]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    judged = {path.name for path in found if path.name.startswith("set01")}
    rows = data["accuracy"]
    for method, sensors in (("linear", 2), ("estimator", 3)):
        mine = [row for row in rows if row["method"] == method]
        assert len(mine) == sensors * len(TIMES_S) * len(PRIORS)
    assert all(row["touches"] == len(judged) for row in rows)
    assert {answer["file"] for answer in data["answers"]} == judged
    assert len(data["errors"]) == sum(row["touches"] - row["right"] for row in rows)
    assert all(error["said"] != error["material"] for error in data["errors"])
    assert [(row["method"], row["touches"]) for row in data["names"]] == [
        (sensors, len(judged)) for sensors in (HEATED, HELPED, BOTH) for _ in RULES
    ]
