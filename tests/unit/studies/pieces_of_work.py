"""Pieces of work for the tests of who does them: functions of a module, as those of the studies are."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import studies.pieces
from studies.pieces import Piece, ReportShare, Work


def drawn(seed: int, count: int) -> float:
    """Something that numpy's linear algebra has a hand in, whose last digits depend on the order of its sums."""
    matrix = np.random.default_rng(seed).standard_normal((count, count))
    return float(np.linalg.svd(matrix @ matrix.T)[1].sum())


def numbers(*until: int) -> Iterator[int]:
    """As many rows as asked for."""
    for each in until:
        yield from range(each)


def emptied(values: list[int]) -> int:
    """Take the last value away, as a pure function must not."""
    return values.pop()


def noted(folder: Path, name: str, fails: bool = False) -> str:
    """Leave a line in a file: how often it was done; may fail."""
    with (folder / name).open("a") as file:
        file.write("done\n")
    if fails and not (folder / "mended").exists():
        raise RuntimeError("interrupted")
    return name


def dies(folder: Path, name: str, times: int) -> str:
    """End the process that does it, as the kernel does when memory runs out, the first times it is tried."""
    tried = len(list(folder.glob(f"{name}-*")))
    (folder / f"{name}-{tried}").touch()
    if tried < times:
        os.kill(os.getpid(), signal.SIGKILL)
    return name


def become_another_version() -> None:
    """Let the process that does it have other code from here on."""
    studies.pieces.code_version = lambda: "another version"  # type: ignore[assignment]


def run(quick: bool, seed: int, progress: ReportShare, work: Work) -> dict[str, Any]:
    """A study that is nothing but pieces."""
    pieces: list[Piece] = [(drawn, (seed + number, 40)) for number in range(6)]
    return {"quick": quick, "drawn": work(pieces, progress), "numbers": work([(numbers, (2, 3))])}
