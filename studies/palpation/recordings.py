"""Reads the recorded palpation: presses of a robot on silicone, meat and liver, and two streams of a moving probe."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from remote_site.traces.press_files import Press, read_presses
from studies.running import Unavailable, recorded_columns

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
    path = _file(folder / name / "presses.csv")
    return [press for press in read_presses(path) if press.contact is not None and press.contact.status != "fail"]


def read_stream(folder: Path, name: str) -> Stream:
    """Return a stream.

    Raises:
        Unavailable: there is no such stream.
        ValueError: it cannot be read.
    """
    path = _file(folder / "continuous" / f"{name}.csv")
    time_s, *place_mm, force_n = recorded_columns(path, "time_s", "x_mm", "y_mm", "z_mm", "fz_n")
    return Stream(time_s, np.column_stack(place_mm), force_n)


def _file(path: Path) -> Path:
    """Return the path of a recording; raise Unavailable if there is none."""
    if not path.is_file():
        raise Unavailable(f"there is no {path}; TELETACTION_DATA has to name a folder with palpation in it")
    return path


def first(press: Press, samples: NDArray[np.bool_] | int) -> Press:
    """Return the press with some of its samples only: the first ones, or those of a mask."""
    kept = slice(samples) if isinstance(samples, int) else samples
    return replace(press, depth_mm=press.depth_mm[kept], force_n=press.force_n[kept], time_s=None, place_mm=None)
