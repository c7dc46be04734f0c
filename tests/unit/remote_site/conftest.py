"""A table that a perfect calibration would give, and one that calibration really made from made-up touches."""

from pathlib import Path

import pytest

from remote_site.thermal.calibration.thermal_calibration import ThermalFit, calibrate_thermal
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_identification import ThermalKnowledge
from tests.unit.remote_site.made_touches import MATERIALS, free_cooling, made_touches, true_table

CALIBRATION_TOUCHES = 16


@pytest.fixture(scope="session")
def knowledge() -> ThermalKnowledge:
    return ThermalKnowledge.of(true_table())


@pytest.fixture(scope="session")
def thermal_fit(tmp_path_factory: pytest.TempPathFactory) -> tuple[ThermalFit, Path]:
    """Fit, and the file of its table."""
    folder = tmp_path_factory.mktemp("calibration")
    labels = ["file,material,object_c"]
    for seed, name in enumerate(MATERIALS):
        for number, touch in enumerate(made_touches(name, CALIBRATION_TOUCHES, seed=100 + seed)):
            touch.write(folder / f"{name}{number}.csv")
            labels.append(f"{name}{number}.csv,{name},{touch.object_c:.3f}")
    free_cooling().write(folder / "air.csv")
    (folder / "labels.csv").write_text("\n".join([*labels, "air.csv,air,"]) + "\n", "utf-8")
    return calibrate_thermal(folder, folder / "table.json", made_on="2026-01-01"), folder / "table.json"


@pytest.fixture(scope="session")
def calibrated(thermal_fit: tuple[ThermalFit, Path]) -> tuple[MaterialTable, Path]:
    """Table, and its file."""
    return thermal_fit[0].table, thermal_fit[1]


@pytest.fixture(scope="session")
def calibrated_knowledge(calibrated: tuple[MaterialTable, Path]) -> ThermalKnowledge:
    return ThermalKnowledge.of(calibrated[0])
