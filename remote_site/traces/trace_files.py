"""Reads trace files of touches and strokes: CSV with a header, strictly checked.

Every error names file, line and column, so that a user can correct the file.
"""

import csv
import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from common.exploration.contact_detector import CONTACT_ON_N
from common.files.printable import printable
from common.wire.packets import MAX_TEXT
from remote_site.traces.units import (
    wrong_ambient,
    wrong_forces,
    wrong_label_speeds,
    wrong_pressures,
    wrong_reading,
    wrong_roughness,
    wrong_speeds,
    wrong_speeds_m_s,
    wrong_stroke_times,
    wrong_times,
)

if TYPE_CHECKING:
    import _csv

Array = NDArray[np.float64]

HELD_S = 0.050
"""Minimum duration of a force of CONTACT_ON_N or more from its first sample that counts as contact, s."""
MOST_BYTES = 1 << 28
"""Maximum size of a file, bytes; reading takes ten to twenty times as much memory."""
LONGEST_HEADER, LONGEST_CELL = 300, 40
"""Maximum numbers of characters of a header and of a cell that a message quotes."""
_SEPARATORS = re.compile("[;\t| ]")
NOT_SIGNALS = ("time_s", "force_n", "speed_mm_s")
_OF_LABELS = {"object_c": wrong_reading, "roughness_um": wrong_roughness, "speed_mm_s": wrong_label_speeds}
"""Check of the unit of each optional column of labels."""


@dataclass(frozen=True, slots=True)
class ThermalTrace:
    """One recorded touch of a thermal sensor, in arrays of one length.

    Attributes:
        time_s: times, (n,), s, ascending; n is at least 2.
        sensor_c: readings of the heated sensor, (n,), C.
        force_n: contact force, (n,), N; contact begins at 0.3 N held for 50 ms.
        ambient_c: temperature of the air, (n,), C; None if unknown.
        reference_c: readings of a second, unheated sensor on the same object, (n,), C; None without one.
        name: name of the touch, for messages; path of the file if it was read from one.

    Raises:
        ValueError: the arrays differ in length, hold a number that is not finite, or are in another unit, or the times
            do not ascend.
    """

    time_s: Array
    sensor_c: Array
    force_n: Array
    ambient_c: Array | None = None
    reference_c: Array | None = None
    name: str = "touch"

    def __post_init__(self) -> None:
        _check_columns(
            self,
            time_s=wrong_times,
            sensor_c=wrong_reading,
            force_n=wrong_forces,
            ambient_c=wrong_ambient,
            reference_c=wrong_reading,
        )

    def contact(self) -> int | None:
        """Return the index of the first sample in contact, or None."""
        touching = self.force_n >= CONTACT_ON_N
        for k in np.flatnonzero(touching & ~np.concatenate(([False], touching[:-1]))):
            # At a low rate no other sample lies within HELD_S: the first one after it must still touch.
            held = int(np.searchsorted(self.time_s, self.time_s[k] + HELD_S - 1e-9))
            if held < len(touching) and touching[k : held + 1].all():
                return int(k)
        return None


@dataclass(frozen=True, slots=True)
class StrokeTrace:
    """One recorded stroke of a texture sensor, in arrays of one length.

    Attributes:
        time_s: times, (n,), s, ascending; n is at least 2.
        signals: signals of the sensor, (n,) or (n, signals), V or the sensor's own unit.
        force_n: contact force, (n,), N; None if unknown.
        speed_m_s: speed of the stroke, (n,), m/s; None if unknown.
        signal_names: name of each signal.
        name: name of the stroke, for messages; path of the file if it was read from one.

    Raises:
        ValueError: as `ThermalTrace`, or samples are missing for a while.
    """

    time_s: Array
    signals: Array
    force_n: Array | None = None
    speed_m_s: Array | None = None
    signal_names: tuple[str, ...] = ("pressure_v",)
    name: str = "stroke"

    def __post_init__(self) -> None:
        if np.ndim(self.signals) == 1:
            object.__setattr__(self, "signals", np.asarray(self.signals, dtype=np.float64)[:, np.newaxis])
        _check_columns(self, time_s=wrong_stroke_times, signals=None, force_n=wrong_forces, speed_m_s=wrong_speeds_m_s)
        if self.signals.shape[1] != len(self.signal_names):
            raise ValueError(f"{self.name}: {self.signals.shape[1]} signals and {len(self.signal_names)} names")

    @property
    def rate_hz(self) -> float:
        """Mean sampling rate, 1/s, rounded to 1e-6: times in a file are rounded, too."""
        return round((len(self.time_s) - 1) / float(self.time_s[-1] - self.time_s[0]), 6)


def _check_columns(trace: ThermalTrace | StrokeTrace, **units: Callable[[Array], str] | None) -> None:
    """Make arrays of a trace's columns, and check length, values and, where there is a check, unit."""
    for column, wrong in units.items():
        values = getattr(trace, column)
        if values is None:
            continue
        array = np.asarray(values, dtype=np.float64)
        object.__setattr__(trace, column, array)
        where = f"{trace.name}: column {column}"
        if array.ndim != (2 if column == "signals" else 1) or len(array) != len(trace.time_s):
            raise ValueError(f"{where}: shape {array.shape} beside {len(trace.time_s)} times")
        if len(array) < 2:
            raise ValueError(f"{where}: fewer than two samples")
        if not np.isfinite(array).all():
            raise ValueError(f"{where}: sample {int(np.argwhere(~np.isfinite(array))[0][0])} is not a finite number")
        if column == "time_s" and (np.diff(array) <= 0.0).any():
            raise ValueError(f"{where}: does not ascend at sample {int(np.argmax(np.diff(array) <= 0.0)) + 1}")
        if wrong is not None and (why := wrong(array)):
            raise ValueError(f"{where}: {why}")


class UnreadFile(ValueError):
    """A file that is missing, or that this user may not read; the message names it."""


def require_all(errors: Sequence[str], files: int) -> None:
    """Raise ValueError with the first error of several files, if there is one, and with the number of them."""
    if errors:
        raise ValueError(errors[0] + (f" ({len(errors)} of {files} files cannot be used)" if files > 1 else ""))


class TraceFile:
    """Text of a CSV file by column; only requested columns are converted to numbers.

    Extra columns may therefore hold anything.
    """

    def __init__(self, path: Path | str) -> None:
        """Read the file.

        Raises:
            UnreadFile: the file is missing, or cannot be read.
            ValueError: the file is empty, too long, not UTF-8, or has a line of the wrong length.
        """
        self.path = Path(path)
        self.lines: list[int] = []
        """Line number of each row of data."""
        try:
            with self.path.open(encoding="utf-8-sig", newline="") as file:
                self._read(csv.reader(self._limited(file), strict=True))
        except OSError as error:
            raise UnreadFile(f"{path}: cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise ValueError(f"{path}: not a UTF-8 CSV file; save it as CSV in UTF-8") from None
        except csv.Error as error:
            after = self.lines[-1] if self.lines else 0
            raise ValueError(
                f"{path}: not a CSV file after line {after}: {error}; look for a quotation mark without its pair"
            ) from None

    def _limited(self, file: IO[str]) -> Iterator[str]:
        """Yield the lines of a file that is not too long; the size of a pipe shows only as it is read."""
        too_long = ValueError(f"{self.path}: longer than {MOST_BYTES >> 20} MiB; split it into several files")
        if os.fstat(file.fileno()).st_size > MOST_BYTES:
            raise too_long
        left = MOST_BYTES
        while line := file.readline(left + 1):
            left -= len(line)
            if left < 0:
                raise too_long
            yield line

    def _read(self, reader: "_csv.Reader") -> None:
        self.names = tuple(cell.strip() for cell in next(reader, ()))
        if not any(self.names):
            raise ValueError(f"{self.path}: line 1: no header")
        if self.names[0].startswith("#"):
            raise ValueError(f"{self.path}: line 1: is a comment; the first line must name the columns")
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"{self.path}: line 1: a column is named twice")
        if len(self.names) == 1 and (found := _SEPARATORS.search(self.names[0])):
            raise ValueError(
                f"{self.path}: line 1: columns are separated by {found[0]!r}; save the file with commas between "
                "columns and decimal points"
            )
        self._columns: list[list[str]] = [[] for _ in self.names]
        time = self.names.index("time_s") if "time_s" in self.names else None
        before: list[str] = []
        for row in reader:
            if not row:
                continue
            if len(row) != len(self.names):
                hint = "; write decimal points, not commas" if len(row) > len(self.names) else ""
                raise ValueError(
                    f"{self.path}: line {reader.line_num}: {len(row)} values under {len(self.names)} columns{hint}"
                )
            # Some recorders write their last sample twice, as a line that repeats the previous one and its time.
            if time is not None and row == before and row[time].strip():
                continue
            before = row
            self.lines.append(reader.line_num)
            for column, cell in zip(self._columns, row, strict=True):
                column.append(cell.strip())

    def texts(self, name: str) -> list[tuple[int, str]]:
        """Return line number and text of every cell of a column; raises ValueError where there is no such column."""
        return list(zip(self.lines, self._cells(name), strict=True))

    def numbers(self, name: str, blank: bool = False) -> Array:
        """Return a column as finite numbers; with `blank`, an empty cell is NaN.

        Raises:
            ValueError: the column does not exist, or a value is missing or not a finite number.
        """
        cells = self._cells(name)
        values = np.full(len(cells), math.nan)
        for k, text in enumerate(cells):
            if blank and not text:
                continue
            try:
                values[k] = float(text)
            except ValueError:
                values[k] = math.nan
            if not math.isfinite(values[k]):
                what = f"not a finite number: {printable(text, LONGEST_CELL)!r}" if text else "missing value"
                raise ValueError(f"{self.path}: line {self.lines[k]}: column {name}: {what}")
        return values

    def _cells(self, name: str) -> list[str]:
        if name not in self.names:
            alike = next((other for other in self.names if other.casefold() == name.casefold()), None)
            what = f"there are {', '.join(self.names)}" if alike is None else f"rename {alike}"
            raise ValueError(f"{self.path}: line 1: column {name} is missing; {printable(what, LONGEST_HEADER)}")
        return self._columns[self.names.index(name)]

    def times(self) -> Array:
        """Return the column `time_s`, s.

        Raises:
            ValueError: as `numbers`, or the times do not ascend strictly, or there are fewer than two.
        """
        time_s = self.numbers("time_s")
        if len(time_s) < 2:
            raise ValueError(f"{self.path}: column time_s: fewer than two lines of data")
        stuck = np.flatnonzero(np.diff(time_s) <= 0.0)
        if len(stuck):
            before, after = (f"{time_s[k]:.12g}" for k in (stuck[0], stuck[0] + 1))
            raise ValueError(
                f"{self.path}: line {self.lines[stuck[0] + 1]}: column time_s does not ascend: {after} follows "
                f"{before}; write more decimals, or leave lines out"
            )
        return time_s


def read_thermal(path: Path | str) -> ThermalTrace:
    """Read a touch: `time_s,sensor_c,force_n` and, if present, `ambient_c`, `reference_c`.

    Raises:
        ValueError: the file cannot be used; the message names file, line and column.
    """
    file = TraceFile(path)
    return ThermalTrace(
        time_s=file.times(),
        sensor_c=file.numbers("sensor_c"),
        force_n=file.numbers("force_n"),
        ambient_c=file.numbers("ambient_c") if "ambient_c" in file.names else None,
        reference_c=file.numbers("reference_c") if "reference_c" in file.names else None,
        name=str(path),
    )


def read_stroke(path: Path | str, signal: str | None = None) -> StrokeTrace:
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
    if names == ("pressure_v",) and len(signals) and (why := wrong_pressures(signals)):
        raise ValueError(f"{path}: column pressure_v: {why}")
    if signal == "mean":
        signals, names = signals.mean(axis=1, keepdims=True), ("mean",)
    return StrokeTrace(
        time_s=file.times(),
        signals=signals,
        force_n=file.numbers("force_n") if "force_n" in file.names else None,
        speed_m_s=_speed_m_s(file) if "speed_mm_s" in file.names else None,
        signal_names=names,
        name=str(path),
    )


def _speed_m_s(file: TraceFile) -> Array:
    speed_mm_s = file.numbers("speed_mm_s")
    if len(speed_mm_s) and (why := wrong_speeds(speed_mm_s)):
        raise ValueError(f"{file.path}: column speed_mm_s: {why}")
    return speed_mm_s / 1000.0


def read_labels(folder: Path, label: str, optional: str | None = None) -> list[tuple[Path, str, float | None]]:
    """Read FOLDER/labels.csv: `file`, the column `label` and, if present, the column `optional` of numbers or blanks.

    Raises:
        ValueError: the file cannot be used, a listed file does not exist or is listed twice, or a label is too long for
            a packet or not printable; the message names file and column.
    """
    file = TraceFile(folder / "labels.csv")
    files, labels = file.texts("file"), file.texts(label)
    extra = file.numbers(optional, blank=True) if optional in file.names else np.full(len(files), math.nan)
    listed: list[tuple[Path, str, float | None]] = []
    for (line, name), (_, word), number in zip(files, labels, extra.tolist(), strict=True):
        if not name or not (folder / name).is_file():
            raise ValueError(f"{file.path}: line {line}: column file: there is no {folder / name}")
        if not word:
            raise ValueError(f"{file.path}: line {line}: column {label}: missing value")
        if len(word) > MAX_TEXT or not word.isprintable():
            raise ValueError(
                f"{file.path}: line {line}: column {label}: {printable(word, MAX_TEXT)!r} is no label: use at most "
                f"{MAX_TEXT} printable characters"
            )
        if optional in _OF_LABELS and not math.isnan(number) and (why := _OF_LABELS[optional](np.array([number]))):
            raise ValueError(f"{file.path}: line {line}: column {optional}: {why}")
        listed.append((folder / name, word, None if math.isnan(number) else number))
    if not listed:
        raise ValueError(f"{file.path}: no traces are listed")
    real = [os.path.realpath(path) for path, _, _ in listed]
    if twice := next((path for path in real if real.count(path) > 1), None):
        raise ValueError(f"{file.path}: column file: {Path(twice).name} is listed twice")
    return listed
