"""Reads the recorded palpation: presses of a robot on silicone, meat and liver, and two streams of a moving probe."""

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from remote_site.traces.press_files import Press, read_presses
from studies.running import Unavailable

Array = NDArray[np.float64]

MATERIALS = {
    "silicone": ("organ_balls", "small_balls", "kidney_bar_t1", "kidney_bar_t2"),
    "meat": ("meat_a", "meat_a_overlap"),
    "liver": ("liver1_r1", "liver1_r4", "liver2_r1", "liver2_r2"),
}
"""Sets of presses of each material; only these may be used to develop with."""
STREAMS = ("ContPalpTrial5", "ContPalpTrial6")
"""Streams of a probe that moves on while its force swings as a sine of 2 Hz."""


@dataclass(frozen=True, slots=True)
class Stream:
    """A stream: times, (n,), s, places of the probe, (n, 3), mm, and upward force, (n,), N."""

    time_s: Array
    place_mm: Array
    force_n: Array


def read_set(folder: Path, name: str) -> list[Press]:
    """Return the presses of a set that the recording states to be good or limited.

    Raises:
        Unavailable: there is no such set.
        ValueError: it cannot be read.
    """
    path = folder / name / "presses.csv"
    if not path.is_file():
        raise Unavailable(f"there is no {path}; TELETACTION_DATA has to name a folder with palpation in it")
    return [press for press in read_presses(path) if press.contact is not None and press.contact.status != "fail"]


def read_stream(folder: Path, name: str) -> Stream:
    """Return a stream.

    Raises:
        Unavailable: there is no such stream.
    """
    path = folder / "continuous" / f"{name}.csv"
    if not path.is_file():
        raise Unavailable(f"there is no {path}; TELETACTION_DATA has to name a folder with palpation in it")
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = {key: np.array([float(row[key]) for row in rows]) for key in ("time_s", "x_mm", "y_mm", "z_mm", "fz_n")}
    place_mm = np.column_stack([columns[key] for key in ("x_mm", "y_mm", "z_mm")])
    return Stream(columns["time_s"], place_mm, columns["fz_n"])


def first(press: Press, samples: NDArray[np.bool_] | int) -> Press:
    """Return the press with some of its samples only: the first ones, or those of a mask."""
    kept = slice(samples) if isinstance(samples, int) else samples
    return replace(press, depth_mm=press.depth_mm[kept], force_n=press.force_n[kept], time_s=None, place_mm=None)
