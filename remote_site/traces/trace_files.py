"""Reads trace files of touches and strokes: CSV with a header, strictly checked.

Every error names file, line and column, so that a user can correct the file.
"""

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from common.exploration.contact_detector import CONTACT_ON_N
from remote_site.traces.units import wrong_forces, wrong_speeds, wrong_temperature, wrong_times

Array = NDArray[np.float64]

HELD_S = 0.050
"""Minimum duration of a force of CONTACT_ON_N or more from its first sample that counts as contact, s."""
NOT_SIGNALS = ("time_s", "force_n", "speed_mm_s")
_OF_LABELS = {"object_c": wrong_temperature, "speed_mm_s": wrong_speeds}
"""Check of the unit of each optional column of labels."""


@dataclass(frozen=True, slots=True)
class ThermalTrace:
    """One recorded touch in arrays of one length; `ambient_c` and `reference_c` are None if the file lacks them."""

    name: str
    time_s: Array
    sensor_c: Array
    force_n: Array
    ambient_c: Array | None
    reference_c: Array | None

    def contact(self) -> int | None:
        """Return the index of the first sample in contact, or None."""
        touching = self.force_n >= CONTACT_ON_N
        for k in np.flatnonzero(touching & ~np.concatenate(([False], touching[:-1]))):
            held = (self.time_s >= self.time_s[k]) & (self.time_s <= self.time_s[k] + HELD_S + 1e-9)
            if touching[held].all() and self.time_s[-1] >= self.time_s[k] + HELD_S - 1e-9:
                return int(k)
        return None


@dataclass(frozen=True, slots=True)
class StrokeTrace:
    """One recorded stroke: signals (samples x signals), and force and speed, or None if unknown."""

    name: str
    time_s: Array
    signals: Array
    signal_names: tuple[str, ...]
    force_n: Array | None
    speed_m_s: Array | None

    @property
    def rate_hz(self) -> float:
        """Mean sampling rate, 1/s."""
        return (len(self.time_s) - 1) / float(self.time_s[-1] - self.time_s[0])


class TraceFile:
    """Text of a CSV file by column; only requested columns are converted to numbers.

    Extra columns may therefore hold anything.
    """

    def __init__(self, path: Path) -> None:
        """Read the file.

        Raises:
            ValueError: the file is missing, empty, not UTF-8, or has a line of the wrong length.
        """
        self.path = path
        try:
            with path.open(encoding="utf-8-sig", newline="") as file:
                rows = list(csv.reader(file))
        except OSError as error:
            raise ValueError(f"{path}: cannot be read: {error.strerror}") from None
        except (UnicodeDecodeError, csv.Error):
            raise ValueError(f"{path}: not a UTF-8 CSV file") from None
        self.names = tuple(cell.strip() for cell in rows[0]) if rows else ()
        if not any(self.names):
            raise ValueError(f"{path}: line 1: no header")
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"{path}: line 1: a column is named twice")
        self.rows = [(number, row) for number, row in enumerate(rows[1:], start=2) if row]
        for number, row in self.rows:
            if len(row) != len(self.names):
                raise ValueError(f"{path}: line {number}: {len(row)} values under {len(self.names)} columns")
        if "time_s" in self.names:
            # some recorders write their last sample twice, as a line that repeats the previous one exactly
            repeated = {line for (_, before), (line, row) in pairwise(self.rows) if row == before}
            self.rows = [(number, row) for number, row in self.rows if number not in repeated]

    def texts(self, name: str) -> list[tuple[int, str]]:
        """Return line number and text of every cell of a column.

        Raises:
            ValueError: there is no such column.
        """
        if name not in self.names:
            raise ValueError(f"{self.path}: line 1: column {name} is missing; there are {', '.join(self.names)}")
        k = self.names.index(name)
        return [(number, row[k].strip()) for number, row in self.rows]

    def numbers(self, name: str) -> Array:
        """Return a column as finite numbers.

        Raises:
            ValueError: the column does not exist, or a value is missing or not a finite number.
        """
        cells = self.texts(name)
        values = np.empty(len(cells))
        for k, (line, text) in enumerate(cells):
            try:
                values[k] = float(text)
            except ValueError:
                values[k] = math.nan
            if not math.isfinite(values[k]):
                what = f"not a finite number: {text!r}" if text else "missing value"
                raise ValueError(f"{self.path}: line {line}: column {name}: {what}")
        return values

    def in_unit(self, name: str, wrong: Callable[[Array], str]) -> Array:
        """Return a column as finite numbers in its unit.

        Args:
            name: the column.
            wrong: returns what the numbers look like in another unit; empty if they may be in this one.

        Raises:
            ValueError: as `numbers`, or the numbers are in another unit.
        """
        values = self.numbers(name)
        if len(values) and (why := wrong(values)):
            raise ValueError(f"{self.path}: column {name}: {why}")
        return values

    def times(self) -> Array:
        """Return the column `time_s`, s.

        Raises:
            ValueError: as `numbers`, or the times do not ascend strictly, are not in s, or there are fewer than two.
        """
        time_s = self.numbers("time_s")
        if len(time_s) < 2:
            raise ValueError(f"{self.path}: column time_s: fewer than two lines of data")
        stuck = np.flatnonzero(np.diff(time_s) <= 0.0)
        if len(stuck):
            raise ValueError(f"{self.path}: line {self.rows[stuck[0] + 1][0]}: column time_s does not ascend")
        return self.in_unit("time_s", wrong_times)


def read_thermal(path: Path) -> ThermalTrace:
    """Read a touch: `time_s,sensor_c,force_n` and, if present, `ambient_c`, `reference_c`.

    Raises:
        ValueError: the file cannot be used; the message names file, line and column.
    """
    file = TraceFile(path)
    return ThermalTrace(
        name=path.name,
        time_s=file.times(),
        sensor_c=file.in_unit("sensor_c", wrong_temperature),
        force_n=file.in_unit("force_n", wrong_forces),
        ambient_c=file.in_unit("ambient_c", wrong_temperature) if "ambient_c" in file.names else None,
        reference_c=file.in_unit("reference_c", wrong_temperature) if "reference_c" in file.names else None,
    )


def read_stroke(path: Path, signal: str | None = None) -> StrokeTrace:
    """Read a stroke: `time_s`, a signal and, if present, `force_n`, `speed_mm_s`.

    Args:
        path: the file.
        signal: name of a column; None means `pressure_v`. `best` returns all columns other than time, force and
            speed, and `mean` returns their mean.

    Raises:
        ValueError: the file cannot be used; the message names file, line and column.
    """
    file = TraceFile(path)
    if signal is None and "pressure_v" not in file.names:
        raise ValueError(
            f"{path}: line 1: column pressure_v is missing; --signal names another of {', '.join(file.names)}, "
            "or best, or mean"
        )
    names: tuple[str, ...] = (signal or "pressure_v",)
    if signal in ("best", "mean"):
        names = tuple(name for name in file.names if name not in NOT_SIGNALS)
        if not names:
            raise ValueError(f"{path}: line 1: no signal column beside {', '.join(file.names)}")
    signals = np.column_stack([file.numbers(name) for name in names])
    if signal == "mean":
        signals, names = signals.mean(axis=1, keepdims=True), ("mean",)
    return StrokeTrace(
        name=path.name,
        time_s=file.times(),
        signals=signals,
        signal_names=names,
        force_n=file.in_unit("force_n", wrong_forces) if "force_n" in file.names else None,
        speed_m_s=file.in_unit("speed_mm_s", wrong_speeds) / 1000.0 if "speed_mm_s" in file.names else None,
    )


def read_labels(folder: Path, label: str, optional: str | None = None) -> list[tuple[Path, str, float | None]]:
    """Read FOLDER/labels.csv: `file`, the column `label` and, if present, the column `optional` of numbers or blanks.

    Raises:
        ValueError: the file cannot be used, or a listed file does not exist; the message names file, line and column.
    """
    file = TraceFile(folder / "labels.csv")
    files, labels = file.texts("file"), file.texts(label)
    extra = file.texts(optional) if optional is not None and optional in file.names else [(0, "")] * len(files)
    listed: list[tuple[Path, str, float | None]] = []
    for (line, name), (_, word), (_, text) in zip(files, labels, extra, strict=True):
        if not name or not (folder / name).is_file():
            raise ValueError(f"{file.path}: line {line}: column file: there is no {folder / name}")
        if not word:
            raise ValueError(f"{file.path}: line {line}: column {label}: missing value")
        try:
            number = float(text) if text else None
        except ValueError:
            number = math.nan
        if number is not None and not math.isfinite(number):
            raise ValueError(f"{file.path}: line {line}: column {optional}: not a finite number: {text!r}")
        listed.append((folder / name, word, number))
    if not listed:
        raise ValueError(f"{file.path}: no traces are listed")
    known = np.array([number for _, _, number in listed if number is not None])
    if optional in _OF_LABELS and len(known) and (why := _OF_LABELS[optional](known)):
        raise ValueError(f"{file.path}: column {optional}: {why}")
    return listed
