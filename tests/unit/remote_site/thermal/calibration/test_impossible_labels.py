"""Labels that contradict the touches are named as the likely cause, and no table is written."""

from pathlib import Path

import pytest

from remote_site.thermal.calibration.thermal_calibration import calibrate_thermal
from tests.unit.remote_site.made_touches import made_touches


@pytest.mark.long
def test_touches_that_fit_no_material_give_no_table(tmp_path: Path) -> None:
    """Each object is said to be warmer than the plate, which cools on it."""
    rows = ["file,material,object_c"]
    for name in ("stone", "plastic"):
        for number, touch in enumerate(made_touches(name, 2, 3, 1.0)):
            touch.write(tmp_path / f"{name}{number}.csv")
            rows.append(f"{name}{number}.csv,{name},36")
    (tmp_path / "labels.csv").write_text("\n".join(rows) + "\n", "utf-8")
    with pytest.raises(ValueError, match=r"labels\.csv: no possible material fits these touches; check the labels"):
        calibrate_thermal(tmp_path, tmp_path / "table.json")
    assert not (tmp_path / "table.json").exists()
