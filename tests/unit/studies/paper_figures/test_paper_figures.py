"""The study of the paper's figures: what they show is what the simulated devices do."""

from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from common.limits import MOTOR_FLOOR_RPM
from studies.paper_figures.figure import plot
from studies.paper_figures.run import run, tables
from tests.unit.studies.written import draw_figure, write_tables


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=0, progress=lambda _: None)


@pytest.mark.long
def test_the_finger_taps_rests_and_strokes_in_this_order_and_the_motor_shows_it() -> None:
    by_mode = {mode: list(rows) for mode, rows in groupby(data()["motor"], key=lambda row: row["mode"])}
    assert list(by_mode) == ["free", "tapping", "quiescent", "stroking"]
    assert max(row["motor_rpm"] for row in by_mode["tapping"]) > 1.5 * MOTOR_FLOOR_RPM
    assert max(row["wanted_rpm"] for row in by_mode["quiescent"]) == 0.0
    stroking = by_mode["stroking"]
    wanted, motor = (np.array([row[name] for row in stroking]) for name in ("wanted_rpm", "motor_rpm"))
    impulses = np.flatnonzero(np.diff(wanted) > 1000.0)
    assert np.diff([stroking[place]["time_s"] for place in impulses[1:]]) == pytest.approx(0.16, abs=0.003)
    assert np.median(motor) == pytest.approx(np.median(wanted), rel=0.025)  # the drive corrects more than a fiftieth
    assert motor.max() > 0.9 * wanted.max()


@pytest.mark.long
@pytest.mark.parametrize("start", ["usual", "colder"])
def test_iron_warms_the_skin_more_than_wood_from_outside_in(start: str) -> None:
    def course(name: str, layer: str) -> np.ndarray:
        rows = [row for row in data()["layers"] if row["start"] == start and row["object"] == name]
        return np.array([row[f"{layer}_c"] - rows[0][f"{layer}_c"] for row in rows if row["time_s"] >= 0.0])

    for layer in ("epidermis", "dermis", "subcutis"):
        assert course("iron", layer)[-1] > course("wood", layer)[-1] > 0.0
        free = [row[f"{layer}_c"] for row in data()["layers"] if row["start"] == start and row["time_s"] < 0.0]
        assert np.ptp(free) < 1e-9
    assert course("iron", "epidermis")[20] > 10.0 * course("iron", "dermis")[20]
    assert course("iron", "dermis")[-1] > 10.0 * course("iron", "subcutis")[-1]


@pytest.mark.long
def test_a_colder_finger_makes_a_larger_step() -> None:
    def step_k(start: str) -> float:
        rows = [row for row in data()["layers"] if row["start"] == start and row["object"] == "iron"]
        return float(rows[-1]["epidermis_c"] - rows[0]["epidermis_c"])

    usual, colder = data()["starts"]
    assert colder["epidermis_c"] < usual["epidermis_c"] < 34.0
    assert 0.5 < step_k("usual") < 0.6 * step_k("colder")


@pytest.mark.long
def test_aluminium_is_known_in_both_ways_when_the_paper_has_it() -> None:
    (at,) = (row for row in data()["identification"] if abs(row["time_s"] - data()["paper_s"]) < 0.01)
    assert at["exponential_object_c"] == pytest.approx(data()["object_c"], abs=0.4)
    assert at["object_c"] == pytest.approx(data()["object_c"], abs=4.0 * at["object_sd_k"])
    assert at["effusivity_j_m2ks05"] == pytest.approx(data()["effusivity_j_m2ks05"], rel=0.15)
    assert at["virtual_heat_conductivity_per_m2_s"] == pytest.approx(at["exponential_rate_per_s"] / 196e-6)


@pytest.mark.long
def test_it_is_written_and_drawn(tmp_path: Path) -> None:
    write_tables(tables(data()), tmp_path)
    draw_figure(plot, data(), tmp_path, 50_000)
