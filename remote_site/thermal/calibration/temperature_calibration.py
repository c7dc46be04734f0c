"""Calibrates the object temperatures of a thermal table against references of known temperature."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from common.runtime.parallel_map import Map, Progress, kept_processes, unseen
from remote_site.thermal.calibration.discrepancy_fit import EARLY_END, Labelled, Seen, courses, learn
from remote_site.thermal.calibration.thermal_calibration import AIR
from remote_site.thermal.calibration.usable_touch import (
    begins_in_contact,
    check_difference,
    lacks_reference,
    touch_of,
    without_reference,
)
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.touch_start import reference_touch
from remote_site.traces.trace_files import ThermalTrace, read_labels, read_thermal

FEWEST = 5
"""Minimum number of touches of a material, for its errors and their scatter."""
UNKNOWN = "unknown"
"""Serial number of a sensor if none was given."""
NARROW_K = 5.0
"""Range of object temperatures of one material below which the error by object stays close to its prior, K."""


@dataclass(frozen=True, slots=True)
class TemperatureFit:
    """A table with temperature errors learned again.

    Attributes:
        before: the table that was given.
        table: the table with the new errors.
        seen: evidence of the touches without discrepancy, by time after contact, s.
        in_contact: names of the traces that begin in contact.
        no_reference: names of the traces without an unheated sensor, if the table has one.
    """

    before: MaterialTable
    table: MaterialTable
    seen: dict[float, list[Seen]] = field(repr=False)
    in_contact: list[str] = field(default_factory=list)
    no_reference: list[str] = field(default_factory=list)

    @property
    def warnings(self) -> list[str]:
        """Limits of the table that a user should know, one line each."""
        first = next(iter(self.seen.values()))
        ranges = {}
        for number, name in enumerate(self.table.names()):
            objects_c = [one.object_c for one in first if one.material == number and one.object_c is not None]
            if objects_c:
                ranges[name] = max(objects_c) - min(objects_c)
        found = [begins_in_contact(name) for name in self.in_contact]
        before, after = self.before.sensor_serial, self.table.sensor_serial
        if UNKNOWN not in (before, after) and before != after:
            found.append(
                f"the materials were calibrated with sensor {before}, and these touches are of {after}: names can be "
                f"wrong; make a table of {after} with `teletaction calibrate thermal`"
            )
        if self.no_reference:
            stays = "the errors of the table's unheated sensor stay as they were; add the column to all traces"
            found.append(lacks_reference(self.no_reference, len(first), stays))
        return found + [
            f"{name}: its references span {range_k:.1f} K; references over {NARROW_K:.0f} K or more "
            "show how the error changes with the object's temperature"
            for name, range_k in ranges.items()
            if range_k < NARROW_K
        ]


def calibrate_temperature(
    table: Path,
    folder: Path,
    out: Path,
    *,
    sensor_serial: str | None = None,
    made_on: str = "",
    processes: int = 1,
    progress: Progress = unseen,
) -> TemperatureFit:
    """Learn temperature errors from FOLDER/labels.csv (`file,material,object_c`) and write a new table to `out`.

    Args:
        table: file of the table.
        folder: holds labels.csv and the traces it names.
        out: file to write.
        sensor_serial: serial number of the sensor that recorded the traces; None for the one in the table.
        made_on: ISO date of the calibration.
        processes: number of processes that share the work; the table does not depend on it.
        progress: is called with the completed share.

    Raises:
        ValueError: a file cannot be used; the message names file, line and column.
    """
    loaded = MaterialTable.load(table)
    where = f"{folder / 'labels.csv'}"
    listed = [each for each in read_labels(folder, "material", "object_c") if each[1].casefold() != AIR]
    missing = next((path for path, _, object_c in listed if object_c is None), None)
    if missing is not None:
        raise ValueError(f"{where}: column object_c: {missing.name} needs the temperature of its object, C")
    labelled = [(label, read_thermal(path), object_c) for path, label, object_c in listed if object_c is not None]
    fit = learn_temperature(loaded, labelled, f"{table}", where, processes=processes, progress=progress)
    changed = {"sensor_serial": sensor_serial or loaded.sensor_serial, "made_on": made_on}
    fit = replace(fit, table=fit.table.model_copy(update=changed))
    fit.table.save(out)
    return fit


def learn_temperature(
    table: MaterialTable,
    labelled: Iterable[tuple[str, ThermalTrace, float]],
    table_name: str = "table",
    where: str = "labels",
    *,
    processes: int = 1,
    progress: Progress = unseen,
) -> TemperatureFit:
    """Learn the temperature errors of the touched materials; all else in the table stays.

    Args:
        table: a table with a discrepancy.
        labelled: label, trace and temperature of the object, C, of each touch.
        table_name: source of the table, for messages.
        where: source of the labels, for messages.
        processes: number of processes that share the work; the table does not depend on it.
        progress: is called with the completed share.

    Raises:
        ValueError: the table has no discrepancy, a material is not in it or has fewer than FEWEST touches, or a touch
            has no contact, is too short, ends early or has no temperature difference.
    """
    if table.discrepancy is None:
        raise ValueError(
            f"{table_name}: field discrepancy: this older table has none; make it again with `teletaction calibrate "
            "thermal`"
        )
    names, needed_s = table.names(), table.discrepancy.times_s[-1]
    touches: list[Labelled] = []
    for label, trace, object_c in labelled:
        if label not in names:
            raise ValueError(f"{where}: column material: {label} is not in {table_name}, which has {', '.join(names)}")
        touch = touch_of(trace)
        check_difference(touch, object_c)
        length_s = float(trace.time_s[-1]) - touch.contact_s
        if length_s < needed_s - 1e-6:
            raise ValueError(f"{trace.name}: the touch lasts {length_s:.2f} s, needs {needed_s:.2f} s as in the table")
        touches.append(Labelled(touch, names.index(label), object_c))
    if not touches:
        raise ValueError(f"{where}: no touches; {FEWEST} or more of a material are needed")
    for number, count in Counter(one.material for one in touches).items():
        if count < FEWEST:
            raise ValueError(
                f"{where}: column material: {names[number]} has {count} touches of known temperature, "
                f"needs {FEWEST} or more; ten are good"
            )
    with kept_processes(processes) as mapped:
        fit = _learned(table, touches, mapped)
        whole = {one.number for one in fit.seen.get(needed_s, ())}
        for number, one in enumerate(touches):
            if number not in whole:
                raise ValueError(f"{one.touch.trace.name}: the touch ends before {needed_s:.2f} s: {EARLY_END}")
        progress(0.5)
        beside = table.reference if table.reference is not None and table.reference.discrepancy is not None else None
        bare = [] if beside is None else without_reference([one.touch for one in touches])
        if beside is not None and not bare:
            others = [one._replace(touch=reference_touch(one.touch)) for one in touches]
            fit = replace(fit, table=fit.table.model_copy(update={"reference": _learned(beside, others, mapped).table}))
        progress(1.0)
    in_contact = [one.touch.trace.name for one in touches if one.touch.first == 0]
    return replace(fit, in_contact=in_contact, no_reference=bare)


def _learned(table: MaterialTable, touches: list[Labelled], mapped: Map) -> TemperatureFit:
    """Learn the errors of one sensor."""
    seen = courses(table, touches, mapped)
    return TemperatureFit(table, table.model_copy(update={"discrepancy": learn(table, seen)}), seen)
