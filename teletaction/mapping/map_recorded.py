"""Reads files of presses and of measured places into the console's tactile map.

A press gives one sample of stiffness at the place of its contact. The columns `roughness_v` and `object_c` (with
`object_c_sd`, if known) give a sample for each line, in files of presses and in files without the column `press`.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.files.each_once import require_each_once
from operator_site.console.map.finger_samples import LEAST_VARIANCE, Sample, slant
from operator_site.console.map.tactile_map import STEEP_SLOPE, TactileMap
from remote_site.traces.press_files import Press, read_presses, require_own_contacts
from remote_site.traces.trace_files import TraceFile
from remote_site.traces.units import wrong_temperature

LEAST_MM = 0.5
"""Smallest extent of the places of a map, mm, unless it has one place."""
LARGEST_MM = 1000.0
"""Largest extent of a map along either axis, mm."""
FARTHEST_MM = 1e6
"""Largest coordinate of a place, mm; a larger number is none of a robot's."""
LARGEST_SD_K = 1000.0
"""Largest standard deviation of an object temperature, K."""
AT_CONTACT = 0.15
"""Largest depth of a first sample that shows the force at contact, as a share of the deepest."""
LEAST_DEPTH_MM = 0.2
"""Smallest depth of a press with a stiffness, mm."""
FALLS_N = 0.1
"""Fall of the force from the shallowest to the deepest sample that shows a wrong sign, N."""
ROUGHNESS_SD = 0.1
"""Standard deviation of a line's ln roughness."""
OBJECT_SD_K = 0.3
"""Standard deviation of a line's object temperature without the column `object_c_sd`, K."""
_FINGER = 1


@dataclass
class MappedPresses:
    """A tactile map and the presses in it.

    Attributes:
        surface: the map.
        used: sample of stiffness of each used press.
        indentation_m: largest depth of each used press, m.
        skipped: press and reason, for each press without a place or a stiffness.
    """

    surface: TactileMap = field(default_factory=TactileMap)
    used: list[Sample] = field(default_factory=list)
    indentation_m: list[float] = field(default_factory=list)
    skipped: list[dict[str, object]] = field(default_factory=list)

    @property
    def places_mm(self) -> NDArray[np.float64]:
        """Places of the used presses, (n, 2), mm."""
        return np.array([(1e3 * sample.x_m, 1e3 * sample.y_m) for sample in self.used]).reshape(-1, 2)


def map_recorded(paths: Sequence[Path]) -> MappedPresses:
    """Make the map of all files together.

    Raises:
        ValueError: a file cannot be used or is named twice, no line gives a sample, or the places are too far apart.
    """
    require_each_once(paths)
    mapped, numbers = MappedPresses(), count(1)
    lines_mm: list[tuple[float, float]] = []
    owners: dict[tuple[Path, int], Path] = {}
    for path in paths:
        file = TraceFile(path)
        if "press" in file.names:
            presses = read_presses(path)
            require_own_contacts(path, presses, owners)
            _take_presses(mapped, path, presses, numbers)
        for sample in _line_samples(file, numbers):
            lines_mm.append((1e3 * sample.x_m, 1e3 * sample.y_m))
            _take(mapped.surface, sample, path)
    every = np.concatenate([mapped.places_mm, np.array(lines_mm).reshape(-1, 2)])
    if not len(every):
        why = f"; {mapped.skipped[0]['reason']}" if mapped.skipped else ""
        raise ValueError(f"no press or line gives a sample for the map{why}")
    extent_mm = np.ptp(every, axis=0).max()
    if 0.0 < extent_mm < LEAST_MM:
        raise ValueError(f"the places are at most {extent_mm:.2g} mm apart: they look like m; multiply by 1000")
    if extent_mm > LARGEST_MM:
        raise ValueError(f"the places are {extent_mm:.0f} mm apart; a map has at most {LARGEST_MM:.0f} mm: split it")
    return mapped


def _take_presses(mapped: MappedPresses, path: Path, presses: Sequence[Press], numbers: Iterator[int]) -> None:
    if all(press.at_mm is None for press in presses):
        raise ValueError(f"{path}: line 1: columns x_mm,y_mm,z_mm are missing, and no contacts.csv beside has them")
    rises_n = [p.force_n[p.depth_mm.argmax()] - p.force_n[p.depth_mm.argmin()] for p in presses if len(p.depth_mm)]
    if np.median(rises_n) < -FALLS_N:
        raise ValueError(
            f"{path}: the force falls with depth_mm in most presses: depth is positive below the contact, and pressing "
            "is positive; change the sign of depth_mm or force_n"
        )
    for press, found in zip(presses, stiffnesses(presses), strict=True):
        place_mm = press.at_mm
        if found is None or place_mm is None:
            reason = "no place" if place_mm is None else "too shallow, failed, or without a rising force"
            mapped.skipped.append({"file": str(path), "press": press.press, "reason": reason})
            continue
        number = next(numbers)
        x_m, y_m = (1e-3 * float(at) for at in place_mm[:2])
        sample = Sample("stiffness", (_FINGER, number, 0), number, _FINGER, x_m, y_m, float(number), *found)
        _take(mapped.surface, sample, path)
        mapped.used.append(sample)
        mapped.indentation_m.append(1e-3 * float(press.depth_mm.max()))
        normal = None if press.contact is None else press.contact.normal
        if normal is not None and math.hypot(*normal[:2]) >= STEEP_SLOPE * abs(normal[2]):
            mapped.surface.take(slant(float(number), _FINGER, x_m, y_m))


def _take(surface: TactileMap, sample: Sample, path: Path) -> None:
    """Add a sample of a file; raises ValueError where its place is too far away for any map."""
    farthest_mm = 1e3 * max(abs(sample.x_m), abs(sample.y_m))
    if farthest_mm > FARTHEST_MM:
        raise ValueError(f"{path}: a coordinate of {farthest_mm:.3g} mm is no place; at most {FARTHEST_MM:g} mm")
    surface.take(sample)


def contact_force_n(presses: Iterable[Press]) -> float:
    """Return the median force at contact, N: sensors have an offset, and a contact is noticed at a force above 0."""
    first = [
        float(press.force_n[0])
        for press in presses
        if len(press.depth_mm) and press.depth_mm[0] <= AT_CONTACT * press.depth_mm.max()
    ]
    return float(np.median(first)) if first else 0.0


def stiffnesses(presses: Sequence[Press]) -> list[tuple[float, float] | None]:
    """Return ln stiffness (N/m) of each press of a file and its variance, by a line through the contact.

    The scatter of the force around the line is the median of all presses, because few samples show it poorly. None
    stands for a press that failed, is too shallow, or has no rising force.
    """
    offset_n = contact_force_n(presses)
    lines = [_line(press, offset_n) for press in presses]
    scatter_n = float(np.median([line.scatter_n for line in lines if line is not None] or [0.0]))
    return [
        None
        if line is None
        else (math.log(line.slope_n_m), max((scatter_n / line.slope_n_m) ** 2 / line.square_m2, LEAST_VARIANCE))
        for line in lines
    ]


class _Line(NamedTuple):
    """Slope of the force over depth, sum of the squared depths, and scatter of the force around the line."""

    slope_n_m: float
    square_m2: float
    scatter_n: float


def _line(press: Press, offset_n: float) -> _Line | None:
    failed = press.contact is not None and press.contact.status == "fail"
    if failed or not len(press.depth_mm) or press.depth_mm.max() < LEAST_DEPTH_MM:
        return None
    depth_m = 1e-3 * np.maximum(press.depth_mm, 0.0)
    force_n = press.force_n - offset_n
    square_m2 = float(depth_m @ depth_m)
    slope_n_m = float(depth_m @ force_n) / square_m2
    off_n = force_n - slope_n_m * depth_m
    if slope_n_m <= 0.0:
        return None
    return _Line(slope_n_m, square_m2, math.sqrt(float(off_n @ off_n) / max(len(off_n) - 1, 1)))


def _line_samples(file: TraceFile, numbers: Iterator[int]) -> Iterator[Sample]:
    """Yield the samples of roughness and temperature of a file's lines.

    Raises:
        ValueError: a file without presses has neither column, or a value is impossible.
    """
    quantities = [name for name in ("roughness_v", "object_c") if name in file.names]
    if not quantities:
        if "press" not in file.names:
            raise ValueError(f"{file.path}: line 1: no column press, roughness_v or object_c; there is nothing to map")
        return
    x_m, y_m = 1e-3 * file.numbers("x_mm"), 1e-3 * file.numbers("y_mm")
    known_sd = file.numbers("object_c_sd", blank=True) if "object_c_sd" in file.names else np.full(len(x_m), np.nan)
    _refuse(file, "object_c_sd", known_sd < 0.0, "must not be negative")
    _refuse(file, "object_c_sd", known_sd > LARGEST_SD_K, f"must be at most {LARGEST_SD_K:g}")
    for name in quantities:
        values = file.numbers(name, blank=True)
        if name == "roughness_v":
            _refuse(file, name, values <= 0.0, "must be above 0")
        elif len(known := values[np.isfinite(values)]) and (why := wrong_temperature(known)):
            raise ValueError(f"{file.path}: column {name}: {why}")
        for k in np.flatnonzero(np.isfinite(values)):
            number, value = next(numbers), float(values[k])
            if name == "roughness_v":
                quantity, value, sd = "roughness", math.log(value), ROUGHNESS_SD
            else:
                quantity, sd = "temperature", OBJECT_SD_K if np.isnan(known_sd[k]) else float(known_sd[k])
            yield Sample(
                quantity,
                (_FINGER, number, 0),
                number,
                _FINGER,
                float(x_m[k]),
                float(y_m[k]),
                float(number),
                value,
                max(sd**2, LEAST_VARIANCE),
            )


def _refuse(file: TraceFile, column: str, wrong: NDArray[np.bool_], why: str) -> None:
    """Raise ValueError for the first line with a wrong value."""
    if wrong.any():
        raise ValueError(f"{file.path}: line {file.lines[int(np.argmax(wrong))]}: column {column}: {why}")
