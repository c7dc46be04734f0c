"""Load a network by name, from a TOML file with phases and faults, or from recorded round trips as CSV."""

import csv
import math
from dataclasses import dataclass
from io import StringIO
from itertools import pairwise
from pathlib import Path
from typing import Self

from pydantic import Field, model_validator

from common.config.file import load_config
from common.files.printable import printable
from common.files.strict_model import StrictModel
from common.files.whole_file import read_whole
from sim_sensors.network.conditions import Conditions, ConditionsOverTime, phased, recorded
from sim_sensors.network.fault import Fault

NETWORKS = Path(__file__).parents[1] / "networks"
MOST_MS = 60_000.0
MOST_CSV_BYTES = 64 << 20
"""Size limit of a recording of round trips, bytes."""
_TIME, _ROUND_TRIP = "send_time_s", "rtt_ms"


@dataclass(frozen=True, slots=True)
class Network:
    """Conditions of a network over time, and its faults in order of time."""

    name: str
    conditions: ConditionsOverTime
    faults: tuple[Fault, ...] = ()


class _Phase(StrictModel):
    from_s: float = Field(ge=0.0)
    delay_ms: float = Field(default=0.0, ge=0.0, le=MOST_MS)
    jitter_ms: float = Field(default=0.0, ge=0.0)
    loss: float = Field(default=0.0, ge=0.0, le=1.0)
    rate_kbit_s: float | None = Field(default=None, gt=0.0)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if self.jitter_ms > self.delay_ms:
            raise ValueError("jitter_ms is more than delay_ms: bytes would arrive before they are sent")
        return self

    def conditions(self) -> Conditions:
        rate_bit_s = math.inf if self.rate_kbit_s is None else 1e3 * self.rate_kbit_s
        return Conditions(1e-3 * self.delay_ms, 1e-3 * self.jitter_ms, self.loss, rate_bit_s)


class _NetworkFile(StrictModel):
    phase: tuple[_Phase, ...] = ()
    round_trips: Path | None = None
    fault: tuple[Fault, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if bool(self.phase) == (self.round_trips is not None):
            raise ValueError("give [[phase]] entries or round_trips, one of the two")
        starts_s = [phase.from_s for phase in self.phase]
        if starts_s and starts_s[0] != 0.0:
            raise ValueError("the first phase must have from_s = 0")
        if any(later <= earlier for earlier, later in pairwise(starts_s)):
            raise ValueError("the phases' from_s must increase")
        return self

    def conditions(self) -> ConditionsOverTime:
        if self.round_trips is not None:
            return _read_round_trips(self.round_trips)
        return phased([phase.from_s for phase in self.phase], [phase.conditions() for phase in self.phase])


def network_names() -> tuple[str, ...]:
    """Return the names of the networks that come with the program."""
    return tuple(sorted(path.stem for path in NETWORKS.glob("*.toml")))


def is_file(name_or_path: str) -> bool:
    """Return whether a network is given by its file instead of its name."""
    return name_or_path.endswith((".toml", ".csv"))


def load_network(name_or_path: str) -> Network:
    """Load a network by its name, or from a path that ends in `.toml` or `.csv`.

    Raises:
        ValueError: unknown name (the known ones are listed), unreadable file, or bad content; the message is one line
            that names file, line and field.
    """
    if not is_file(name_or_path) and name_or_path not in network_names():
        known = ", ".join(network_names())
        raise ValueError(f"unknown network {name_or_path!r}; known: {known} (or a path that ends in .toml or .csv)")
    path = Path(name_or_path) if is_file(name_or_path) else NETWORKS / f"{name_or_path}.toml"
    if path.suffix == ".csv":
        return Network(path.stem, _read_round_trips(path))
    file = load_config(path, _NetworkFile)
    return Network(path.stem, file.conditions(), tuple(sorted(file.fault, key=lambda fault: fault.at_s)))


def _read_round_trips(path: Path) -> ConditionsOverTime:
    """Read recorded round trips; raise ValueError, with file and line, for invalid content."""
    times_s: list[float] = []
    round_trips_s: list[float] = []
    try:
        content, _ = read_whole(path, MOST_CSV_BYTES)
        rows = csv.DictReader(StringIO(content.decode("utf-8-sig"), newline=""))
        for column in (_TIME, _ROUND_TRIP):
            if column not in (rows.fieldnames or ()):
                raise ValueError(f"{path}:1: no column {column}")
        for row in rows:
            where = f"{path}:{rows.line_num}"
            times_s.append(_number(row, _TIME, where))
            round_trips_s.append(1e-3 * _number(row, _ROUND_TRIP, where))
            if times_s[1:] and times_s[-1] <= times_s[-2]:
                raise ValueError(f"{where}: {_TIME}: {times_s[-1]:g} does not follow {times_s[-2]:g}")
            if not 0.0 <= round_trips_s[-1] <= 2e-3 * MOST_MS:
                raise ValueError(f"{where}: {_ROUND_TRIP}: must be from 0 to {2 * MOST_MS:g}")
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path}: cannot read round trips: {getattr(error, 'strerror', error)}") from None
    if len(times_s) < 2:
        raise ValueError(f"{path}: at least two rows of round trips are needed, there are {len(times_s)}")
    return recorded(times_s, round_trips_s)


def _number(row: dict[str, str], column: str, where: str) -> float:
    try:
        value = float(row[column])
    except (TypeError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{where}: {column}: {printable(repr(row[column]), 60)} is no number")
    return value
