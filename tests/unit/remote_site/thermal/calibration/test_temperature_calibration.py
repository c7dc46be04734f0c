"""Touches of references teach the errors of object temperatures, and nothing else."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from remote_site.thermal.calibration.discrepancy_fit import OBJECT_SD, UNKNOWN_SPREAD
from remote_site.thermal.calibration.temperature_calibration import FEWEST, calibrate_temperature, learn_temperature
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.recorded.identify_thermal import identify_traces
from remote_site.traces.trace_files import ThermalTrace, read_thermal
from tests.unit.remote_site.made_touches import AMBIENT_C, MadeTouch, made_touches

pytestmark = pytest.mark.long

OFF_K = 1.0
"""How much colder the references say they are than the table believes, K."""
OBJECTS_C = AMBIENT_C + np.array([-4.0, -2.0, 0.0, 1.0, 2.0, 4.0])


def references(name: str = "plastic", count: int = 6, seconds: float = 6.2, reference: bool = False) -> list[MadeTouch]:
    made = made_touches(name, count, 70, seconds, object_c=OBJECTS_C[:count])
    return [replace(one, reference_c=one.sensor_c) if reference else one for one in made]


def folder_of(made: list[MadeTouch], folder: Path, off_k: float = 0.0, blank: bool = False) -> Path:
    """A folder with labels, which name temperatures that are `off_k` lower."""
    lines = ["file,material,object_c"]
    for number, one in enumerate(made):
        one.write(folder / f"{number}.csv")
        lines.append(f"{number}.csv,{one.name},{'' if blank and number == 1 else f'{one.object_c - off_k:.3f}'}")
    (folder / "labels.csv").write_text("\n".join(lines) + "\n", "utf-8")
    return folder


def traces(made: list[MadeTouch], folder: Path, off_k: float = 0.0) -> list[tuple[str, ThermalTrace, float]]:
    return [
        (one.name, read_thermal(one.write(folder / f"{n}.csv")), one.object_c - off_k) for n, one in enumerate(made)
    ]


def forgetful(table: MaterialTable) -> MaterialTable:
    """The table as a calibration without object temperatures makes it."""
    assert table.discrepancy is not None
    zero = np.zeros_like(table.discrepancy.by_plate)
    unknown = {
        "by_plate": zero.tolist(),
        "by_object": zero.tolist(),
        "by_object_sd": (zero + OBJECT_SD).tolist(),
        "spread": (zero + UNKNOWN_SPREAD).tolist(),
        "stated_sd": [1.0] * len(zero),
        "known_objects": [False] * zero.shape[1],
    }
    return table.model_copy(update={"discrepancy": table.discrepancy.model_copy(update=unknown)})


def test_a_reference_that_begins_in_contact_is_named(calibrated: tuple[MaterialTable, Path], tmp_path: Path) -> None:
    first, *others = references()
    (tmp_path / "touches").mkdir()
    folder = folder_of([first.where(first.time_s > -0.005), *others], tmp_path / "touches")
    fit = calibrate_temperature(calibrated[1], folder, tmp_path / "new.json")
    (warning,) = fit.warnings
    assert warning.startswith(f"{folder / '0.csv'}: begins in contact")


def test_a_table_of_another_sensor_is_named(calibrated: tuple[MaterialTable, Path], tmp_path: Path) -> None:
    path = tmp_path / "table.json"
    calibrated[0].model_copy(update={"sensor_serial": "T1"}).save(path)
    for serial, count in (("T1", 0), ("T2", 1)):
        fit = calibrate_temperature(
            path, folder_of(references(), tmp_path), tmp_path / "new.json", sensor_serial=serial
        )
        assert sum("calibrated with sensor T1, and these touches are of T2" in each for each in fit.warnings) == count


def test_the_table_follows_the_references_and_keeps_the_rest(
    calibrated: tuple[MaterialTable, Path], tmp_path: Path
) -> None:
    table, path = calibrated
    folder = folder_of(references(), tmp_path, OFF_K)
    (folder / "air.csv").write_text("no touch\n", "utf-8")
    with (folder / "labels.csv").open("a", encoding="utf-8") as labels:
        labels.write("air.csv,Air,\n")
    fit = calibrate_temperature(path, folder, tmp_path / "new.json", made_on="2026-02-01")
    found = MaterialTable.load(tmp_path / "new.json")
    assert found.made_on == "2026-02-01"
    assert found.sensor_serial == table.sensor_serial
    assert found.model_dump(exclude={"discrepancy", "made_on", "content_hash"}) == table.model_dump(
        exclude={"discrepancy", "made_on", "content_hash"}
    )
    assert fit.warnings == []
    plastic, before, after = table.names().index("plastic"), table.discrepancy, found.discrepancy
    assert before is not None
    assert after is not None
    assert after.stated_sd == before.stated_sd, "other materials use it too"
    assert after.plate_k[plastic] == pytest.approx(10.0, abs=0.1)
    assert np.array_equal(np.delete(after.plate_k, plastic), np.delete(before.plate_k, plastic))
    assert after.sharpness == before.sharpness
    for name in ("by_plate", "by_object", "spread"):
        old, new = np.array(getattr(before, name)), np.array(getattr(after, name))
        assert np.array_equal(np.delete(new, plastic, 1), np.delete(old, plastic, 1))
    new_touch = read_thermal(made_touches("plastic", 1, 71)[0].write(tmp_path / "touch.csv"))
    one, other = (identify_traces(each, [new_touch], (5.0,))[0]["object_c"] for each in (table, found))
    assert one is not None
    assert other is not None
    assert one - other == pytest.approx(OFF_K, abs=0.25)


def test_a_table_without_object_temperatures_learns_one_material(
    calibrated: tuple[MaterialTable, Path], tmp_path: Path
) -> None:
    table = forgetful(calibrated[0])
    fit = learn_temperature(table, traces(references(), tmp_path))
    assert table.discrepancy is not None
    found = fit.table.discrepancy
    assert found is not None
    plastic = table.names().index("plastic")
    assert found.known_objects == [number == plastic for number in range(len(table.materials))]
    spread = np.array(found.spread)
    assert (np.delete(spread, plastic, 1) == UNKNOWN_SPREAD).all()
    assert spread[-1, plastic] < UNKNOWN_SPREAD
    assert found.stated_sd != table.discrepancy.stated_sd, "no other material depends on it"


def test_the_reference_sensor_learns_too(calibrated: tuple[MaterialTable, Path], tmp_path: Path) -> None:
    table = calibrated[0].model_copy(update={"reference": calibrated[0]})
    fit = learn_temperature(table, traces(references(reference=True), tmp_path, OFF_K))
    assert fit.warnings == []
    found = fit.table
    assert found.reference is not None
    assert found.reference.discrepancy == found.discrepancy
    made = [*references()[:2], *references(reference=True)[2:]]
    partly = learn_temperature(table, traces(made, tmp_path, OFF_K))
    assert partly.table.reference == calibrated[0], "two of these touches have no reference sensor"
    (warning,) = partly.warnings
    assert warning.startswith(f"{tmp_path / '0.csv'}: column reference_c is missing in 2 of 6 touches, so that the ")


def test_references_of_one_temperature_are_mentioned(calibrated: tuple[MaterialTable, Path], tmp_path: Path) -> None:
    made = made_touches("stone", FEWEST, 72, 6.2, object_c=AMBIENT_C)
    (warning,) = learn_temperature(calibrated[0], traces(made, tmp_path)).warnings
    assert warning.startswith("stone: its references span 0.0 K")


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (references(count=4), "plastic has 4 touches of known temperature, needs 5 or more"),
        (
            [replace(one, name="brass") for one in references()],
            "column material: brass is not in .*, which has metal, stone, plastic",
        ),
        (references(seconds=3.0), "0.csv: the touch lasts 3.00 s, needs 6.00 s as in the table"),
        (made_touches("plastic", 6, 70, 6.2, object_c=AMBIENT_C + 9.9), "too close to calibrate"),
        ([one.until(-0.2) for one in references()], "no contact"),
    ],
)
def test_touches_that_cannot_teach(
    made: list[MadeTouch], words: str, calibrated: tuple[MaterialTable, Path], tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=words):
        calibrate_temperature(calibrated[1], folder_of(made, tmp_path), tmp_path / "new.json")
    assert not (tmp_path / "new.json").exists()


def test_a_reference_needs_its_temperature(calibrated: tuple[MaterialTable, Path], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"labels.csv: column object_c: 1.csv needs the temperature"):
        calibrate_temperature(calibrated[1], folder_of(references(), tmp_path, blank=True), tmp_path / "new.json")


def test_no_touches_and_an_older_table(calibrated: tuple[MaterialTable, Path], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="labels: no touches; 5 or more"):
        learn_temperature(calibrated[0], [])
    older = calibrated[0].model_copy(update={"discrepancy": None})
    with pytest.raises(ValueError, match=r"table: field discrepancy: .* `teletaction calibrate thermal`"):
        learn_temperature(older, traces(references(), tmp_path))
