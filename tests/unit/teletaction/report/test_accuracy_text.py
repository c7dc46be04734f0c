"""Reports of calibrations show the discrepancy, the accuracy to expect, and their own reliability."""

from pathlib import Path

import numpy as np
import pytest

import teletaction as tt
from remote_site.thermal.calibration.discrepancy_fit import OBJECT_SD
from remote_site.thermal.calibration.thermal_calibration import MISFIT
from remote_site.thermal.discrepancy import Discrepancy
from teletaction.report.accuracy_text import temperature_text
from teletaction.report.calibration_report import calibration_text
from tests.commands import command, one_line
from tests.places import TABLES

pytestmark = pytest.mark.long

OBJECTS_C = (20.0, 21.5, 23.0, 24.0, 25.0, 26.5)
SECONDS = 6.2


@pytest.fixture(scope="module")
def table() -> tt.MaterialTable:
    """A table whose calibration knew no object temperatures."""
    shipped = tt.MaterialTable.load(TABLES / "materials.json")
    count = len(shipped.materials)
    times_s = [1.0, 3.0, 5.0]
    zeros = [[0.0] * count for _ in times_s]
    unknown = Discrepancy(
        times_s=times_s,
        plate_k=[10.0] * count,
        coldest_k=[0.0] * count,
        warmest_k=[0.0] * count,
        by_plate=zeros,
        by_object=zeros,
        by_object_sd=[[OBJECT_SD] * count for _ in times_s],
        spread=[[0.05] * count for _ in times_s],
        stated_sd=[1.0] * len(times_s),
        sharpness=[1.0] * len(times_s),
        known_objects=[False] * count,
    )
    return shipped.model_copy(update={"discrepancy": unknown})


@pytest.fixture(scope="module")
def touches() -> list[tuple[str, tt.ThermalTrace, float]]:
    return [
        ("aluminium", tt.simulate_thermal("aluminium", seed, seconds=SECONDS, object_c=object_c), object_c)
        for seed, object_c in enumerate(OBJECTS_C)
    ]


@pytest.fixture(scope="module")
def fit(table: tt.MaterialTable, touches: list[tuple[str, tt.ThermalTrace, float]]) -> tt.TemperatureFit:
    return tt.calibrate_temperature(table, touches)


def test_a_temperature_calibration_says_what_is_known(fit: tt.TemperatureFit) -> None:
    text = temperature_text(fit)
    lines = text.splitlines()
    others = [name for name in fit.table.names() if name != "aluminium"]
    assert f"no known object temperature: {', '.join(others)}." in text
    assert sum("not known" in line for line in lines) == 3
    assert any(line.startswith("aluminium") and "-3.0..+3.5" in line for line in lines)
    assert "expected 1 / 3 / 5 s after contact" in text
    heading = next(number for number, line in enumerate(lines) if line.startswith("one finger"))
    assert lines[heading + 1].split()[:4] == ["aluminium", "100", "100", "100"]
    assert "reliability" in text
    assert "populations" not in text, "these touches have not taught the populations"
    assert len(lines) < 30


def test_the_report_of_a_calibration_says_it_too(fit: tt.TemperatureFit) -> None:
    names = [entry.name for entry in fit.table.materials]
    bad = fit.table.materials[0].model_copy(update={"misfit": 2 * MISFIT})
    worse = fit.table.materials[1].model_copy(update={"misfit": 2 * MISFIT})
    table = fit.table.model_copy(update={"materials": [bad, worse, *fit.table.materials[2:]]})
    text = calibration_text(tt.ThermalFit(table, names, np.array([1.0]), np.zeros((4, 1)), fit.seen))
    assert "The populations were fitted to these same touches" in text
    warnings = [
        line for line in text.splitlines() if line.startswith("warning: ") and "does not fit this sensor" in line
    ]
    known = fit.table.discrepancy is not None and fit.table.discrepancy.known_objects[:2]
    ends = ["cannot correct the temperature", "subtracts the error"]
    assert [ends[is_known] in warning for is_known, warning in zip(known or [], warnings, strict=True)] == [True, True]


def test_an_older_table_has_no_such_lines(fit: tt.TemperatureFit) -> None:
    older = fit.table.model_copy(update={"discrepancy": None})
    text = calibration_text(tt.ThermalFit(older, older.names(), np.array([1.0]), np.zeros((4, 1)), {}))
    assert "expected" not in text
    assert "reliability" not in text


def test_the_command_writes_a_table_and_a_report(
    table: tt.MaterialTable, fit: tt.TemperatureFit, tmp_path: Path
) -> None:
    traces = tmp_path / "references"
    for seed in range(5):
        made = command(
            *("simulate", "thermal", "--material", "aluminium", "--out", traces, "--seed", seed, "--seconds", SECONDS)
        )
        assert made.code == 0
    table.save(tmp_path / "table.json")
    words = ("calibrate", "temperature", "--table", tmp_path / "table.json", "--traces", traces, "--processes", 1)
    outcome = command(*words, "--out", tmp_path / "new.json", "--report", tmp_path / "report", "--serial", "T7")
    assert (outcome.code, outcome.out) == (0, "")
    found = tt.MaterialTable.load(tmp_path / "new.json")
    assert found.sensor_serial == "T7"
    assert found.discrepancy is not None
    assert found.discrepancy.known_objects == [name == "aluminium" for name in found.names()]
    assert (tmp_path / "report" / "report.txt").read_text("utf-8").startswith("sensor T7")
    table.model_copy(update={"discrepancy": None}).save(tmp_path / "table.json")
    assert "calibrate thermal" in one_line(command(*words, "--out", tmp_path / "newer.json"), 2)
