"""Defines what each study shares with its caller and with others: progress, recordings, and tables."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remote_site.traces.trace_files import TraceFile

Progress = Callable[[float | str], object]
"""Takes the progress of a study: the share done, 0..1, or its present step in words."""
Tables = Mapping[str, Sequence[Mapping[str, Any]]]
"""Rows of each table of a study, by the table's name."""


class Unavailable(ValueError):
    """A requirement of a study is missing; the message names it and how to supply it."""


def data_folder(name: str) -> Path:
    """Return a folder of recordings in the one that TELETACTION_DATA names; raise Unavailable if that is not set."""
    if not (named := os.environ.get("TELETACTION_DATA")):
        raise Unavailable(f"TELETACTION_DATA has to name the folder that holds {name}")
    return Path(named) / name


def data_files(name: str) -> list[Path]:
    """Return the CSV files of a folder in TELETACTION_DATA, sorted; none where it is not there."""
    return sorted(data_folder(name).glob("*.csv")) if os.environ.get("TELETACTION_DATA") else []


def recorded_columns(path: Path, *names: str) -> NDArray[np.float64]:
    """Return columns of a recording, (names, samples).

    Raises:
        ValueError: the file cannot be used; the message names file, line and column.
    """
    file = TraceFile(path)
    if not file.lines:
        raise ValueError(f"{path}: no line of data")
    return np.array([file.numbers(name) for name in names])


def tables_of(*names: str) -> Callable[[Mapping[str, Any]], Tables]:
    """Return the `tables` of a study whose tables are the parts of its data with these names."""
    return lambda data: {name: data[name] for name in names}
