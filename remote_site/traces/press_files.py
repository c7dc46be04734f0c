"""Reads files of presses: CSV with a header, strictly checked, and `contacts.csv` beside it.

A press is a probe pushed into an object, in a motion or in steps. The columns are `press,depth_mm,force_n` and, where
known, `time_s` and `x_mm,y_mm,z_mm`. Steps need no times. Every error names file, line and column.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from remote_site.traces.trace_files import TraceFile
from remote_site.traces.units import wrong_depths, wrong_forces

Array = NDArray[np.float64]

CONTACTS = "contacts.csv"
"""Name of the file of contacts, beside the file of presses."""
STATUSES = ("ok", "limit", "fail")
"""Statuses of a contact: complete, ended early by the limit of the force, failed."""
_PLACE, _NORMAL = ("x_mm", "y_mm", "z_mm"), ("nx", "ny", "nz")


@dataclass(frozen=True, slots=True)
class Contact:
    """Contact that the recording states for one press.

    Attributes:
        place_mm: place of the probe's centre at contact, (3,), mm; None if unknown.
        normal: unit vector out of the surface, (3,); None if unknown.
        status: `ok`, `limit` or `fail`.
    """

    place_mm: Array | None = None
    normal: Array | None = None
    status: str = "ok"


@dataclass(frozen=True, slots=True)
class Press:
    """One recorded press, in arrays of one length; n is 0 for a press that only `contacts.csv` lists.

    Attributes:
        press: number of the press.
        depth_mm: depths below the place of contact, (n,), mm, in the order of time.
        force_n: forces along the normal, (n,), N; pressing is positive.
        time_s: times, (n,), s, ascending; None if unknown.
        place_mm: places of the probe's centre, (n, 3), mm; None if unknown.
        contact: what the recording states about the contact; None if nothing.

    Raises:
        ValueError: the arrays differ in length, or hold a number that is not finite.
    """

    press: int
    depth_mm: Array
    force_n: Array
    time_s: Array | None = None
    place_mm: Array | None = None
    contact: Contact | None = None

    def __post_init__(self) -> None:
        for column, wide in (("depth_mm", ()), ("force_n", ()), ("time_s", ()), ("place_mm", (3,))):
            if (values := getattr(self, column)) is None:
                continue
            array = np.asarray(values, dtype=np.float64)
            object.__setattr__(self, column, array)
            where = f"press {self.press}: column {column}"
            if array.shape != (len(self.depth_mm), *wide):
                raise ValueError(f"{where}: shape {array.shape} beside {len(self.depth_mm)} depths")
            if not np.isfinite(array).all():
                raise ValueError(
                    f"{where}: sample {int(np.argwhere(~np.isfinite(array))[0][0])} is not a finite number"
                )

    @property
    def at_mm(self) -> Array | None:
        """Place of the contact, (3,), mm: the stated one, else that of the first sample; None if unknown."""
        if self.contact is not None and self.contact.place_mm is not None:
            return self.contact.place_mm
        return None if self.place_mm is None or not len(self.place_mm) else self.place_mm[0]


def read_presses(path: Path | str) -> list[Press]:
    """Read all presses of a file in the order of their first lines, then those that only `contacts.csv` lists.

    Raises:
        ValueError: a file cannot be used; the message names file, line and column.
    """
    file = TraceFile(path)
    numbers = _press_numbers(file)
    depth_mm, force_n = file.numbers("depth_mm"), file.numbers("force_n")
    if not len(numbers):
        raise ValueError(f"{path}: no line of data")
    for column, why in (("depth_mm", wrong_depths(depth_mm)), ("force_n", wrong_forces(force_n))):
        if why:
            raise ValueError(f"{path}: column {column}: {why}")
    time_s = file.numbers("time_s", blank=True) if "time_s" in file.names else None
    place_mm = _columns(file, _PLACE)
    contacts = read_contacts(Path(path).with_name(CONTACTS))
    presses = []
    for press in dict.fromkeys(numbers.tolist()):
        rows = np.flatnonzero(numbers == press)
        presses.append(
            Press(
                press=press,
                depth_mm=depth_mm[rows],
                force_n=force_n[rows],
                time_s=None if time_s is None else _times(file, rows, time_s),
                place_mm=None if place_mm is None else place_mm[rows],
                contact=contacts.pop(press, None),
            )
        )
    return presses + [Press(press, np.empty(0), np.empty(0), contact=contact) for press, contact in contacts.items()]


def require_own_contacts(path: Path, presses: Sequence[Press], owners: dict[tuple[Path, int], Path]) -> None:
    """Refuse a `contacts.csv` that states the contact of one number of a press in two files.

    Args:
        path: a file of presses.
        presses: its presses.
        owners: file of each contact and number of a press that was read before; those of this file are added.

    Raises:
        ValueError: another file has a press with this number and this contact.
    """
    contacts = path.with_name(CONTACTS)
    for press in presses:
        if press.contact is None or not len(press.depth_mm):
            continue
        if (other := owners.setdefault((contacts.resolve(), press.press), path)) != path:
            raise ValueError(
                f"{contacts}: column press: press {press.press} is in {other.name} and in {path.name}; give each file "
                f"a folder with its own {CONTACTS}"
            )


def read_contacts(path: Path | str) -> dict[int, Contact]:
    """Read `press` and, where present, `x_mm,y_mm,z_mm,nx,ny,nz,status`, by press; no file gives no contact.

    Raises:
        ValueError: the file cannot be used; the message names file, line and column.
    """
    if not Path(path).exists():
        return {}
    file = TraceFile(path)
    numbers = _press_numbers(file).tolist()
    place_mm, normal = _columns(file, _PLACE, blank=True), _columns(file, _NORMAL, blank=True)
    statuses = file.texts("status") if "status" in file.names else [(line, "ok") for line in file.lines]
    contacts: dict[int, Contact] = {}
    for k, (line, status) in enumerate(statuses):
        if numbers[k] in contacts:
            raise ValueError(f"{path}: line {line}: column press: press {numbers[k]} is listed twice")
        if status not in STATUSES:
            raise ValueError(f"{path}: line {line}: column status: {status!r} is none of {', '.join(STATUSES)}")
        contacts[numbers[k]] = Contact(_known(place_mm, k), _unit(_known(normal, k)), status)
    return contacts


def _press_numbers(file: TraceFile) -> NDArray[np.int64]:
    """Return the column `press` as whole numbers."""
    values = file.numbers("press")
    for (line, text), value in zip(file.texts("press"), values, strict=True):
        if not (value.is_integer() and 0.0 <= value < 2.0**53):
            raise ValueError(f"{file.path}: line {line}: column press: not a whole number from 0: {text!r}")
    return values.astype(np.int64)


def _columns(file: TraceFile, names: tuple[str, ...], blank: bool = False) -> Array | None:
    """Return these columns, (n, columns), or None if the file has none of them; one alone is an error."""
    if not any(name in file.names for name in names):
        return None
    return np.column_stack([file.numbers(name, blank) for name in names])


def _times(file: TraceFile, rows: NDArray[np.intp], time_s: Array) -> Array | None:
    """Return the times of the press in these rows; None if all are blank."""
    mine = time_s[rows]
    if np.isnan(mine).all():
        return None
    wrong: Mapping[str, NDArray[np.bool_]] = {
        "missing value beside other times of this press": np.isnan(mine),
        "does not ascend within the press": np.concatenate(([False], np.diff(mine) <= 0.0)),
    }
    for why, where in wrong.items():
        if where.any():
            raise ValueError(f"{file.path}: line {file.lines[rows[where.argmax()]]}: column time_s: {why}")
    return mine


def _known(values: Array | None, k: int) -> Array | None:
    """Return row k, or None if it is not wholly known."""
    return None if values is None or np.isnan(values[k]).any() else values[k]


def _unit(normal: Array | None) -> Array | None:
    """Return the normal with length 1; None for a zero vector, which stands for an unknown one."""
    if normal is None:
        return None
    length = float(np.linalg.norm(normal))
    return normal / length if length > 0.0 else None
